//! The views say what the grammar says.

use std::collections::BTreeSet;

use super::super::grammar::Grammar;
use super::{
    Holds, Made, common, criterion, experiment, file, kinds, program, rating, road_user, scenario, suite,
    value,
};
use ::scenario::AGGREGATES;

fn made() -> Vec<&'static Made> {
    [
        common::MADE,
        criterion::MADE,
        experiment::MADE,
        file::MADE,
        program::MADE,
        rating::MADE,
        road_user::MADE,
        scenario::MADE,
        suite::MADE,
        value::MADE,
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// The rules of a view or choice.
fn rules(view: &str) -> BTreeSet<String> {
    if let Some(made) = made().into_iter().find(|made| made.view == view) {
        return made.rules.iter().map(|rule| format!("{rule:?}")).collect();
    }
    let choices = [
        criterion::CHOICES,
        experiment::CHOICES,
        kinds::CHOICES,
        road_user::CHOICES,
        scenario::CHOICES,
        value::CHOICES,
    ];
    let (_, views) = choices.into_iter().flatten().find(|(name, _)| *name == view).unwrap();
    views.iter().flat_map(|view| rules(view)).collect()
}

#[test]
fn views_have_the_parts_that_the_grammar_gives_them() {
    let grammar = Grammar::read();
    let mut wrong = Vec::new();
    for made in made() {
        let own: Vec<String> = made.rules.iter().map(|rule| format!("{rule:?}")).collect();
        for (part, holds) in made.parts {
            let can =
                |parts: &BTreeSet<String>| own.iter().any(|rule| !grammar.possible(rule).is_disjoint(parts));
            let must = |parts: &BTreeSet<String>| own.iter().all(|rule| grammar.always(rule, parts));
            let right = match holds {
                Holds::Always(view) => must(&rules(view)),
                Holds::Perhaps(view) => can(&rules(view)) && !must(&rules(view)),
                Holds::Any(view) => can(&rules(view)),
                Holds::Word(rule) => can(&BTreeSet::from([format!("{rule:?}")])),
            };
            if !right {
                wrong.push(format!("{}.{part}: {holds:?}", made.view));
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

#[test]
fn the_grammar_knows_every_aggregate() {
    let grammar = Grammar::read();
    let known: BTreeSet<String> = AGGREGATES.iter().map(|known| format!("kw_{}", known.word)).collect();
    let words = ["statistic_name", "quantile", "rate"].into_iter().flat_map(|rule| grammar.possible(rule));
    assert_eq!(words.filter(|word| word.starts_with("kw_")).collect::<BTreeSet<_>>(), known);
}

#[test]
fn no_rule_has_two_views() {
    let mut seen = BTreeSet::new();
    for rule in made().into_iter().flat_map(|made| made.rules) {
        assert!(seen.insert(format!("{rule:?}")), "{rule:?}");
    }
}
