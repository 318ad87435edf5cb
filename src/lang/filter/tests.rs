//! Filter expressions from text to what they select.

use proptest::prelude::*;

use super::predicate::{PREDICATES, Predicate};
use super::*;
use crate::{Severity, Style, render_all};
use scenario::{Assignment, Value};

/// Three trials and a search, told apart by a letter.
fn chosen(texts: &[&str]) -> String {
    let filters =
        Filters::parse(texts).unwrap_or_else(|failure| panic!("{}", failure.render(Style::default())));
    with_subjects(|subjects| {
        "abcs"
            .chars()
            .zip(subjects)
            .filter(|(_, subject)| filters.matches(subject))
            .map(|(letter, _)| letter)
            .collect()
    })
}

fn with_subjects<R>(use_them: impl FnOnce(&[Subject]) -> R) -> R {
    let tags = ["paper", "zebra"].map(String::from);
    let varied = |tta: f64, style: &str| {
        [("tta", format!("{tta}s"), Value::Number(tta)), ("style", style.into(), Value::Word(style.into()))]
            .map(|(name, label, value)| Assignment { name: name.into(), label, value })
    };
    let (early, late) = (varied(6.0, "normal"), varied(14.0, "cautious"));
    let trial = |name, tags, model, variation| Subject {
        suite: "zebra",
        kind: SCENARIO,
        name,
        tags,
        models: vec![model],
        controllers: vec!["carla_behavior"],
        files: vec!["scenarios/zebra/walkers.scn", "suites/zebra.suite"],
        variation,
    };
    let search = Subject {
        kind: "search",
        files: vec!["suites/zebra.suite"],
        ..trial("low_pet", &[], "commotions", &[])
    };
    use_them(&[
        trial("carla_walker", &tags, "carla_walker", &early),
        trial("carla_walker", &tags, "carla_walker", &late),
        trial("human", &tags[1..], "commotions", &late),
        search,
    ])
}

#[test]
fn predicates_ask_about_everything_there_is_to_know() {
    for (text, expected) in [
        ("scenario(walker)", "ab"),
        ("scenario(=human)", "c"),
        ("scenario(/^h.m/)", "c"),
        ("scenario(zebra/human)", "c"),
        ("scenario(#zebra/*)", "abc"),
        ("suite(zebra)", "abcs"),
        ("suite(#zeb*)", "abcs"),
        ("suite(zeb)", ""),
        ("tag(paper)", "ab"),
        ("tag(~e)", "abc"),
        ("model(commotions)", "cs"),
        ("controller(carla_*)", "abcs"),
        ("file(walkers.scn)", "abc"),
        ("file(suites/*.suite)", "abcs"),
        ("file(/walkers/)", "abc"),
        ("block(low)", "s"),
        ("block(=low_pet)", "s"),
        ("kind(search)", "s"),
        ("kind(scenario)", "abc"),
        ("all()", "abcs"),
        ("none()", ""),
        ("variation(tta)", "abc"),
        ("variation(tta=6s)", "a"),
        ("variation( tta = 6000 ms )", "a"),
        ("variation(tta >= 10 s)", "bc"),
        ("variation(tta != 6 s)", "bc"),
        ("variation(tta ≠ 6 s)", "bc"),
        ("variation(tta < 1 min)", "abc"),
        ("variation(tta#1?s)", "bc"),
        ("variation(tta/^1/)", "bc"),
        ("variation(tta~4)", "bc"),
        ("variation(style=cautious)", "bc"),
        ("variation(style!=cautious)", "a"),
    ] {
        assert_eq!(chosen(&[text]), expected, "{text}");
    }
}

#[test]
fn operators_combine_predicates() {
    for (text, expected) in [
        ("scenario(walker) & tag(paper)", "ab"),
        ("scenario(walker) and variation(tta=6s)", "a"),
        ("tag(zebra) - tag(paper)", "c"),
        ("tag(zebra) & !tag(paper)", "c"),
        ("tag(zebra) and not tag(paper)", "c"),
        ("not not tag(paper)", "ab"),
        ("scenario(human) | kind(search)", "cs"),
        ("scenario(human)+kind(search)", "cs"),
        ("scenario(human) or kind(search)", "cs"),
        // `&` binds more tightly than `|`, whichever stands first.
        ("kind(search) | tag(zebra) & variation(tta=6s)", "as"),
        ("tag(zebra) & variation(tta=6s) | kind(search)", "as"),
        ("(kind(search) | tag(zebra)) & variation(tta=6s)", "a"),
        ("!(tag(paper) | kind(search))", "c"),
        ("not(tag(paper))", "cs"),
        ("all() - kind(search) - variation(tta=6s)", "bc"),
        (" \n( (scenario(human)) )\t", "c"),
    ] {
        assert_eq!(chosen(&[text]), expected, "{text}");
    }
}

#[test]
fn several_expressions_are_a_union_and_none_means_everything() {
    assert_eq!(chosen(&["scenario(human)", "variation(tta=6s)"]), "ac");
    assert_eq!(chosen(&[]), "abcs");
}

#[test]
fn brackets_may_stand_in_patterns() {
    assert_eq!(chosen(&["scenario(/(hum|dog)an/)"]), "c");
    assert_eq!(chosen(&[r"scenario(=a\)b) | scenario(/zebra\/hu/)"]), "c");
}

/// What is wrong, as codes and words.
fn wrong(text: &str) -> Vec<(&'static str, String)> {
    let failure = Filters::parse(&[text]).expect_err(text);
    for finding in &failure.diagnostics {
        assert!(!finding.hints.is_empty() && !finding.labels[0].text.is_empty(), "{text}: {finding:?}");
    }
    failure.diagnostics.into_iter().map(|finding| (finding.code.name(), finding.message)).collect()
}

#[test]
fn all_mistakes_of_an_expression_are_found_at_once() {
    let found = wrong("scenaro(zebra) & & tag(/(/) model(#a***) && kind(");
    let codes: Vec<_> = found.iter().map(|(code, _)| *code).collect();
    assert_eq!(codes, ["E1001", "E1002", "E1003", "E1002", "E1003", "E1002", "E1003", "E1002"], "{found:?}");
}

#[test]
fn findings_look_like_those_of_scenario_files() {
    let failure = Filters::parse(&["tag(paper) & scenaro(zebra)", "zebra || all"]).unwrap_err();
    insta::assert_snapshot!(render_all(&failure.diagnostics, &failure.sources, Style::default()));
}

#[test]
fn deep_brackets_are_refused_before_they_take_long() {
    let deep = format!("{}all(){}", "(".repeat(100_000), ")".repeat(100_000));
    assert_eq!(wrong(&deep)[0].0, "E0105");
    assert!(!wrong(&"(".repeat(64)).is_empty());
    assert!(!wrong(&"!".repeat(100_000)).is_empty());
    assert_eq!(chosen(&[&format!("{}all(){}", "(".repeat(60), ")".repeat(60))]), "abcs");
}

fn warnings(filters: &Filters) -> Vec<Diagnostic> {
    with_subjects(|subjects| filters.warnings(&|show: &mut Show| subjects.iter().for_each(&mut *show)))
}

#[test]
fn what_matches_nothing_is_named_with_what_would() {
    let hints = |text: &str| {
        let filters = Filters::parse(&[text]).unwrap();
        let warnings = warnings(&filters);
        assert!(warnings.iter().all(|finding| finding.severity == Severity::Warning));
        warnings.into_iter().flat_map(|finding| finding.hints).collect::<Vec<_>>()
    };
    assert_eq!(hints("tag(papr) | all()"), ["did you mean `paper`?"]);
    assert_eq!(hints("!model(jaywalker)"), ["there are `carla_walker`, `commotions`"]);
    assert_eq!(hints("variation(tta=7s)"), ["there are `tta=14s`, `tta=6s`"]);
    assert_eq!(hints("variation(tts=6s)"), ["did you mean `tta`?"]);
    assert_eq!(hints("scenario(tta=6s)"), ["values of variations are asked for by `variation(tta=6s)`"]);
    assert_eq!(hints("scenario(humans)"), ["did you mean `human`?"]);
    assert_eq!(hints("tag(paper) & none()"), [""; 0]);
}

#[test]
fn every_example_of_the_reference_can_be_read() {
    let text = reference();
    for predicate in PREDICATES {
        Filters::parse(&[predicate.example]).unwrap();
        assert!(predicate.example.starts_with(&format!("{}(", predicate.name)));
        assert_eq!(Predicate::of(predicate.name).map(|found| found.asked), Some(predicate.asked));
    }
    let examples: Vec<&str> = text.split("-E '").skip(1).filter_map(|rest| rest.split('\'').next()).collect();
    assert!(examples.len() >= 3);
    Filters::parse(&examples).unwrap();
}

/// Pieces that expressions are made of, right and wrong.
const PIECES: &[&str] = &[
    "scenario(",
    "tag(",
    "variation(",
    "all()",
    "none()",
    "model(a)",
    ")",
    "(",
    "&",
    "|",
    "+",
    "-",
    "!",
    "not ",
    " and ",
    " or ",
    "&&",
    ",",
    "=",
    "~",
    "#",
    "/",
    "tta",
    "6 s",
    ">=",
    "<",
    " ",
    "\\",
    "\\)",
    "*",
    "**",
    "[",
    "é",
    "\n",
    "zebra",
];

proptest! {
    #[test]
    fn no_expression_makes_the_reader_panic(pieces in prop::collection::vec(prop::sample::select(PIECES), 0..40), random: String) {
        for text in [pieces.concat(), random] {
            match Filters::parse(&[&text]) {
                Ok(filters) => drop(warnings(&filters)),
                Err(failure) => {
                    prop_assert!(!failure.diagnostics.is_empty());
                    failure.render(Style { colour: true });
                }
            }
        }
    }

    #[test]
    fn a_difference_is_an_intersection_with_the_opposite(left in 0..6usize, right in 0..6usize) {
        let parts = ["tag(paper)", "kind(search)", "variation(tta=6s)", "scenario(human)", "all()", "none()"];
        let (left, right) = (parts[left], parts[right]);
        prop_assert_eq!(chosen(&[&format!("{left} - {right}")]), chosen(&[&format!("{left} & !{right}")]));
        prop_assert_eq!(
            chosen(&[&format!("!({left} | {right})")]),
            chosen(&[&format!("!{left} & !{right}")])
        );
        prop_assert_eq!(chosen(&[left, right]), chosen(&[&format!("{left} | {right}")]));
    }
}
