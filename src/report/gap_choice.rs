//! People who choose a gap in two streams of cars beside populations and models: for the terminal as tables, and drawn.

use std::fmt::Write;

use super::chart::{AxisQuantity, PeopleShares, SHARE_LINES, ShareLine, SharePoint, ShareSeries, standalone};
use super::columns::columns;
use results::{
    ALL_PEOPLE, ChosenGap, ChosenGaps, FittedTo, GapChoices, GapChooser, GapCondition, GapMeasure, GapUnit,
    PEOPLE_GROUPS, PeopleNumber, PeopleNumbers,
};

const STRING: &str = "writing to a string cannot fail";

/// In place of an unknown value.
const UNKNOWN: &str = "–";

/// Shares for each gap, pairs, shares that had gone before, and what else is compared; people with their errors beside each.
pub fn render_gap_choices(choices: &GapChoices) -> String {
    let GapChoices { people, choosers } = choices;
    let mut text = format!("people who choose a gap in two streams of cars ({})\n", people.what);
    for (index, chooser) in choosers.iter().enumerate() {
        writeln!(text, "  {}  {}", letter(index), introduced(chooser)).expect(STRING);
    }
    let each = people.conditions.iter().enumerate();
    let shares = each.clone().map(|(place, condition)| {
        let own = |one: &ChosenGap| with_error(one.share, one.error);
        line(condition_name(condition), Some(&condition.share), choosers, |gaps| own(&gaps.conditions[place]))
    });
    let pairs = each.clone().map(|(place, condition)| {
        let own = |gaps: &ChosenGaps| percent(gaps.conditions[place].pairs);
        line(condition_name(condition), condition.pairs.as_ref(), choosers, own)
    });
    let gone = each.map(|(place, condition)| {
        let own = |gaps: &ChosenGaps| went_before(&gaps.conditions[place]);
        of_choosers(condition_name(condition), choosers, own)
    });
    text += &table("took the gap, % of those still there", PEOPLE_GROUPS, shares, choosers);
    text += &apart(choices);
    text += &table("took it both times, % of pairs of a person's trials", PEOPLE_GROUPS, pairs, choosers);
    text += &table("had gone before it opened, % (before the first car, %)", NOBODY, gone, choosers);
    let measures = people.measures.iter().enumerate().map(|(place, (measure, known))| {
        let mut cells = vec![measure_name(*measure)];
        cells.extend(known.iter().map(|number| observed(number, measure.unit())));
        let own = |gaps: &ChosenGaps| {
            gaps.measures[place].map_or_else(|| UNKNOWN.to_string(), |value| number(value, measure.unit()))
        };
        cells.extend(choosers.iter().map(|one| one.chosen.as_ref().map_or_else(|| UNKNOWN.to_string(), own)));
        cells
    });
    text += &table("also", PEOPLE_GROUPS, measures, choosers);
    text += "  ±: one standard error, by drawing persons anew; ≤: never seen, upper bound at 95 %; –: no run tells\n";
    text += "  alone: mean over persons; with others: virtual people crossed in the gap with the people that were observed, and none do in runs\n";
    text += "  entry and time left: of persons that took the gap; a person that is hit in it took it, with nothing left\n";
    text
}

fn letter(index: usize) -> String {
    let letter = char::from(b'A' + (index % 26) as u8);
    if index < 26 { letter.to_string() } else { format!("{letter}{}", index / 26) }
}

fn introduced(chooser: &GapChooser) -> String {
    let GapChooser { name, digest, fitted, persons, runs, chosen } = chooser;
    if chosen.is_none() {
        return format!("{name}: walks the same whatever comes, and so takes no gap");
    }
    let fitted = match fitted {
        FittedTo::ThesePeople => "fitted to these people".to_string(),
        FittedTo::Others => "held back: not fitted to these people".to_string(),
        FittedTo::Unknown(reason) => format!("unknown whether fitted to these people: {reason}"),
    };
    let digest = digest.as_ref().map_or_else(String::new, |digest| format!(", digest {digest}"));
    let persons = match persons {
        1 => format!("one person, {runs} runs in every condition"),
        _ => format!("{persons} persons, {runs} runs of each in every condition"),
    };
    format!("{name}: {fitted}; {persons}{digest}")
}

/// A line of a table: people, as far as they are known, and what is compared with them.
fn line(
    name: String,
    people: Option<&PeopleNumbers>,
    choosers: &[GapChooser],
    own: impl Fn(&ChosenGaps) -> String,
) -> Vec<String> {
    let unknown = || UNKNOWN.to_string();
    let known = (0..PEOPLE_GROUPS.len())
        .map(|group| people.map_or_else(unknown, |numbers| observed(&numbers[group], GapUnit::Share)));
    let others = choosers.iter().map(|one| one.chosen.as_ref().map_or_else(unknown, &own));
    [name].into_iter().chain(known).chain(others).collect()
}

/// A line that is not about people.
fn of_choosers(name: String, choosers: &[GapChooser], own: impl Fn(&ChosenGaps) -> String) -> Vec<String> {
    let others = choosers.iter().map(|one| one.chosen.as_ref().map_or_else(|| UNKNOWN.to_string(), &own));
    [name].into_iter().chain(NOBODY.map(str::to_string)).chain(others).collect()
}

/// Headings of columns that say nothing.
const NOBODY: [&str; PEOPLE_GROUPS.len()] = [""; PEOPLE_GROUPS.len()];

fn table(
    what: &str,
    groups: [&str; PEOPLE_GROUPS.len()],
    rows: impl Iterator<Item = Vec<String>>,
    choosers: &[GapChooser],
) -> String {
    let groups = groups.map(str::to_string);
    let headings = [what.to_string()].into_iter().chain(groups).chain((0..choosers.len()).map(letter));
    let lines: Vec<Vec<String>> = [headings.collect()].into_iter().chain(rows).collect();
    columns(&lines)
}

/// How far the shares of each are from those of people.
fn apart(choices: &GapChoices) -> String {
    let GapChoices { people, choosers } = choices;
    let rows = PEOPLE_GROUPS.iter().enumerate().map(|(group, name)| {
        let own = |gaps: &ChosenGaps| match gaps.apart(people, group) {
            None => UNKNOWN.to_string(),
            Some((apart, known)) if known < people.conditions.len() => {
                format!("{:.1} of {known}", 100.0 * apart)
            }
            Some((apart, _)) => format!("{:.1}", 100.0 * apart),
        };
        of_choosers(format!("from {name}"), choosers, own)
    });
    let mut text = table("root mean square of these, points", NOBODY, rows, choosers);
    text += "  halves of the persons differ by 2 to 3 points: below that nothing is learned\n";
    text
}

fn condition_name(condition: &GapCondition) -> String {
    let GapCondition { gap, before, with_others, .. } = condition;
    let where_it_is = if *with_others { "with others" } else { "alone" };
    format!("{gap} s after gaps of {before} s, {where_it_is}")
}

fn measure_name(measure: GapMeasure) -> String {
    match measure {
        GapMeasure::ShortTaken(gap) => format!("gaps of {gap} s before it taken, of those offered, %"),
        GapMeasure::EntryAfterPrevious(gap) => {
            format!("{gap} s: entry after the previous car's front, median, s")
        }
        GapMeasure::LittleLeft(gap) => format!("{gap} s: less than 1 s left on leaving the near lane, %"),
        GapMeasure::MeanSpeed => "mean speed on the near lane, m/s".to_string(),
        GapMeasure::SpeedInGap(gap) => format!("{gap} s: mean speed on the near lane, median, m/s"),
        GapMeasure::Collision => "collisions, %".to_string(),
        GapMeasure::NeverAcross => "not across within 60 s, %".to_string(),
        GapMeasure::StepBack => "stepped back, %".to_string(),
    }
}

fn number(value: f64, unit: GapUnit) -> String {
    match unit {
        GapUnit::Share if value > 0.0 && value < 0.01 => format!("{:.2}", 100.0 * value),
        GapUnit::Share => format!("{:.1}", 100.0 * value),
        GapUnit::Time | GapUnit::Speed => format!("{value:.2}"),
    }
}

fn percent(value: Option<f64>) -> String {
    value.map_or_else(|| UNKNOWN.to_string(), |value| number(value, GapUnit::Share))
}

fn with_error(value: Option<f64>, error: Option<f64>) -> String {
    match (value, error) {
        (Some(_), Some(error)) => format!("{} ± {:.1}", percent(value), 100.0 * error),
        _ => percent(value),
    }
}

fn observed(known: &PeopleNumber, unit: GapUnit) -> String {
    let own = number(known.value, unit);
    match (known.error, known.at_most) {
        (_, Some(bound)) => format!("{own} (≤ {})", number(bound, unit)),
        (Some(error), None) => format!("{own} ± {}", number(error, unit)),
        (None, None) => own,
    }
}

/// In how many runs the person had gone before the gap opened, %.
fn went_before(chosen: &ChosenGap) -> String {
    let share = |count: usize| 100.0 * count as f64 / chosen.runs as f64;
    format!("{:.1} ({:.1})", share(chosen.before_first + chosen.in_shorter), share(chosen.before_first))
}

/// The share that is taken against the gap, as SVG that stands alone: people by country with their errors, and a line for each
/// population and model of which a share is known.
pub fn draw_gap_choices(choices: &GapChoices) -> String {
    let panel = |with_others: bool| {
        let places: Vec<usize> = (0..choices.people.conditions.len())
            .filter(|place| choices.people.conditions[*place].with_others == with_others)
            .collect();
        let conditions = || places.iter().map(|place| &choices.people.conditions[*place]);
        let group = |group: usize| ShareSeries {
            name: people_name(group),
            points: conditions()
                .map(|one| {
                    let PeopleNumber { value, error, at_most } = one.share[group];
                    let above = at_most.unwrap_or(value + error.unwrap_or(0.0)).min(1.0);
                    SharePoint {
                        x: one.gap,
                        share: value,
                        within: ((value - error.unwrap_or(0.0)).max(0.0), above),
                    }
                })
                .collect(),
        };
        let drawn = |chooser: &GapChooser| {
            let gaps = chooser.chosen.as_ref()?;
            // There is no line without a point.
            gaps.conditions.iter().find_map(|one| one.share)?;
            let of = places
                .iter()
                .map(|place| (choices.people.conditions[*place].gap, gaps.conditions[*place].share));
            let points: Vec<(f64, f64)> = of.filter_map(|(gap, share)| Some((gap, share?))).collect();
            Some(ShareLine { name: chooser.name.clone(), points })
        };
        PeopleShares {
            title: panel_title(with_others, conditions()),
            x: AxisQuantity::new("gap", "s"),
            people: [ALL_PEOPLE, 0, 1].map(group).to_vec(),
            lines: choices.choosers.iter().filter_map(drawn).collect(),
        }
    };
    let panels = [panel(false), panel(true)];
    let more = panels[0].lines.len().saturating_sub(SHARE_LINES);
    let mut remarks = vec!["share of those still there who take the gap; bars: one standard error, or up to the bound at 95 % where none did".to_string()];
    if more > 0 {
        remarks.push(format!("{more} more are in the tables alone"));
    }
    standalone(
        "People who choose a gap in two streams of cars",
        &panels.each_ref().map(PeopleShares::to_svg),
        &panels[0].legend(),
        &remarks,
    )
}

fn panel_title<'c>(with_others: bool, conditions: impl Iterator<Item = &'c GapCondition>) -> String {
    let mut before: Vec<String> = conditions.map(|one| format!("{} s", one.before)).collect();
    before.dedup();
    let where_it_is = if with_others { "with others" } else { "alone" };
    format!("{where_it_is}, after gaps of {}", before.join(" and "))
}

fn people_name(group: usize) -> String {
    match group {
        ALL_PEOPLE => "people, both countries".to_string(),
        _ => format!("people in {}", PEOPLE_GROUPS[group]),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use results::PeopleAtGaps;

    fn numbers(value: f64) -> PeopleNumbers {
        let error = Some(0.034);
        let known = PeopleNumber { value, error, at_most: None };
        [known, PeopleNumber { value: 0.0, error: None, at_most: Some(0.022) }, known]
    }

    fn choices() -> GapChoices {
        let condition = |gap, before, with_others| GapCondition {
            gap,
            before,
            with_others,
            share: numbers(gap / 10.0),
            pairs: with_others.then(|| numbers(gap / 20.0)),
        };
        let gap = |taken: usize, share| ChosenGap {
            runs: 400,
            before_first: 40,
            in_shorter: 20,
            taken,
            share,
            error: share.map(|_| 0.021),
            pairs: share.map(|share: f64| share * share),
        };
        let nobody = ChosenGap { before_first: 400, in_shorter: 0, ..gap(0, None) };
        let chooser = |name: &str, chosen, fitted| GapChooser {
            name: name.into(),
            digest: (name != "scripted").then(|| "0123456789abcdef".into()),
            fitted,
            persons: 200,
            runs: 2,
            chosen,
        };
        let some = ChosenGaps {
            conditions: vec![gap(68, Some(0.2)), gap(34, Some(0.1)), gap(340, Some(1.0))],
            measures: vec![Some(0.0012), Some(1.402), None],
        };
        let none =
            ChosenGaps { conditions: vec![gap(0, Some(0.0)), nobody, nobody], measures: vec![None; 3] };
        let unknown = FittedTo::Unknown("it does not say what it was fitted to".into());
        GapChoices {
            people: PeopleAtGaps {
                what: "CrossCDR, half A".into(),
                conditions: vec![
                    condition(3.5, 2.0, false),
                    condition(4.0, 3.0, true),
                    condition(6.5, 2.5, true),
                ],
                measures: vec![
                    (GapMeasure::ShortTaken(3.0), numbers(0.0013)),
                    (GapMeasure::EntryAfterPrevious(4.0), numbers(1.38)),
                    (GapMeasure::LittleLeft(6.5), numbers(0.5)),
                ],
            },
            choosers: vec![
                chooser("humans", Some(some), FittedTo::Others),
                chooser("own, looks for 1 s", Some(none), unknown),
                chooser("scripted", None, FittedTo::Others),
            ],
        }
    }

    #[test]
    fn people_stand_beside_populations_and_models() {
        insta::assert_snapshot!(render_gap_choices(&choices()));
    }

    #[test]
    fn an_unknown_share_is_not_drawn() {
        let svg = draw_gap_choices(&choices());
        assert!(!svg.contains("NaN") && !svg.contains("scripted"), "{svg}");
        assert!(svg.contains("with others, after gaps of 3 s and 2.5 s"), "{svg}");
        // Of the second population one share is known, 0, and two are unknown.
        assert_eq!(svg.matches("<title>own, looks for 1 s").count(), 1, "{svg}");
        insta::assert_snapshot!(svg);
    }

    #[test]
    fn what_was_fitted_is_called_so() {
        let mut choices = choices();
        choices.choosers[0].fitted = FittedTo::ThesePeople;
        let text = render_gap_choices(&choices);
        assert!(text.contains("A  humans: fitted to these people;") && !text.contains("held back"), "{text}");
    }
}
