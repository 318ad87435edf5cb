//! Gaps that people took in two streams of cars, and gaps that populations and models take in the same street.

/// Groups of people: the two countries, and both.
pub const PEOPLE_GROUPS: [&str; 3] = ["Germany", "Japan", "both"];

/// The place of all people in [`PEOPLE_GROUPS`].
pub const ALL_PEOPLE: usize = 2;

/// A number about people.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PeopleNumber {
    /// In the unit of what it is about; shares from 0 to 1.
    pub value: f64,
    /// Its standard error, by drawing persons anew; `None` where no person did so.
    pub error: Option<f64>,
    /// The one-sided bound at 95 %, where no person did so.
    pub at_most: Option<f64>,
}

/// One for each of [`PEOPLE_GROUPS`].
pub type PeopleNumbers = [PeopleNumber; PEOPLE_GROUPS.len()];

/// A gap that is looked at, with the shorter ones before it.
#[derive(Debug, Clone, PartialEq)]
pub struct GapCondition {
    /// s
    pub gap: f64,
    /// Each of the gaps before it, s.
    pub before: f64,
    /// Whether virtual people crossed in the gap when people were observed. There are none in runs.
    pub with_others: bool,
    /// Share that took the gap, of the persons that were still there.
    pub share: PeopleNumbers,
    /// The share of pairs of a person's trials in which the person took it both times, where that is known.
    pub pairs: Option<PeopleNumbers>,
}

/// Unit of a measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GapUnit {
    /// A share from 0 to 1; reports show %.
    Share,
    /// s
    Time,
    /// m/s
    Speed,
}

/// What else is compared.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum GapMeasure {
    /// The share of the gaps of that size (s) before the one that is looked at, of those that were offered, that was taken.
    ShortTaken(f64),
    /// From the front of the previous car to entering the near lane, median of the persons that take the gap of that size (s) with others.
    EntryAfterPrevious(f64),
    /// Of the persons that take the gap of that size (s) with others, the share that leave the near lane less than 1 s before the next car.
    LittleLeft(f64),
    /// Mean speed on the near lane.
    MeanSpeed,
    /// The same, median of the persons that take the gap of that size (s) with others.
    SpeedInGap(f64),
    /// Share of trials with a collision.
    Collision,
    /// Share of trials in which the person had not crossed after 60 s.
    NeverAcross,
    /// Share of trials with a step back out of a lane.
    StepBack,
}

impl GapMeasure {
    /// Unit of its values.
    pub fn unit(self) -> GapUnit {
        match self {
            Self::EntryAfterPrevious(_) => GapUnit::Time,
            Self::MeanSpeed | Self::SpeedInGap(_) => GapUnit::Speed,
            _ => GapUnit::Share,
        }
    }
}

/// What people did.
#[derive(Debug, Clone, PartialEq)]
pub struct PeopleAtGaps {
    /// What the file says that it is.
    pub what: String,
    /// In the order of the report: single gaps first, then gaps with others.
    pub conditions: Vec<GapCondition>,
    /// In the order of the report.
    pub measures: Vec<(GapMeasure, PeopleNumbers)>,
}

/// Whether a population or a model was fitted to these people.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FittedTo {
    /// To them, so that likeness is not a finding.
    ThesePeople,
    /// To others, or to none.
    Others,
    /// Unknown, for this reason.
    Unknown(String),
}

/// A population or a model in the street of the experiment.
#[derive(Debug, Clone, PartialEq)]
pub struct GapChooser {
    /// What it is called, with the time for which it looks before it may go.
    pub name: String,
    /// Of a population: see `Population::digest`.
    pub digest: Option<String>,
    /// Whether it was fitted to the people that it is compared with.
    pub fitted: FittedTo,
    /// How many persons; 1 of a model without individuals.
    pub persons: usize,
    /// Runs of each person in every condition.
    pub runs: u32,
    /// `None` of a model that walks the same whatever cars do: it takes no gap, it meets one.
    pub chosen: Option<ChosenGaps>,
}

/// What came of its runs.
#[derive(Debug, Clone, PartialEq)]
pub struct ChosenGaps {
    /// In the order of [`PeopleAtGaps::conditions`].
    pub conditions: Vec<ChosenGap>,
    /// In the order of [`PeopleAtGaps::measures`]; `None` where no run says anything.
    pub measures: Vec<Option<f64>>,
}

/// What came of the runs of a condition.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ChosenGap {
    /// All of them.
    pub runs: usize,
    /// In which the person had gone before the first car.
    pub before_first: usize,
    /// In which the person had gone in one of the shorter gaps.
    pub in_shorter: usize,
    /// In which the person took the gap.
    pub taken: usize,
    /// Of the persons that were still there when the gap opened, the share that took it; `None` if none were.
    pub share: Option<f64>,
    /// Its standard error, by drawing persons anew; `None` of fewer than two, and where all of them did the same.
    pub error: Option<f64>,
    /// The share of pairs of a person's runs in which it took the gap both times; `None` where no person was there twice.
    pub pairs: Option<f64>,
}

impl ChosenGap {
    /// In how many runs the person was still there when the gap opened.
    pub fn there(&self) -> usize {
        self.runs - self.before_first - self.in_shorter
    }
}

impl ChosenGaps {
    /// The root mean square of what shares are apart from those of a group of people, with how many shares are known; `None` if none is.
    pub fn apart(&self, people: &PeopleAtGaps, group: usize) -> Option<(f64, usize)> {
        let each = self.conditions.iter().zip(&people.conditions);
        let apart: Vec<f64> =
            each.filter_map(|(one, known)| Some(one.share? - known.share[group].value)).collect();
        let squares: f64 = apart.iter().map(|one| one * one).sum();
        (!apart.is_empty()).then(|| ((squares / apart.len() as f64).sqrt(), apart.len()))
    }
}

/// People beside populations and models.
#[derive(Debug, Clone, PartialEq)]
pub struct GapChoices {
    /// What people did.
    pub people: PeopleAtGaps,
    /// What is compared with them, in the order in which it was asked for.
    pub choosers: Vec<GapChooser>,
}

#[cfg(test)]
mod tests {
    use super::*;

    fn numbers(value: f64) -> PeopleNumbers {
        [value, value + 0.1, value].map(|value| PeopleNumber { value, error: None, at_most: None })
    }

    fn chosen(share: Option<f64>) -> ChosenGap {
        ChosenGap { runs: 4, before_first: 1, in_shorter: 2, taken: 0, share, error: None, pairs: None }
    }

    #[test]
    fn what_nobody_met_is_in_no_distance() {
        let condition = |value| GapCondition {
            gap: 4.0,
            before: 3.0,
            with_others: true,
            share: numbers(value),
            pairs: None,
        };
        let people = PeopleAtGaps {
            what: String::new(),
            conditions: vec![condition(0.2), condition(0.5), condition(0.9)],
            measures: Vec::new(),
        };
        let of = |shares: [Option<f64>; 3]| ChosenGaps {
            conditions: shares.map(chosen).to_vec(),
            measures: vec![],
        };
        // 0.3 and 0.4 apart; the third is unknown and not 0.
        let (apart, known) = of([Some(0.5), Some(0.1), None]).apart(&people, ALL_PEOPLE).unwrap();
        assert!((apart - (0.25f64 / 2.0).sqrt()).abs() < 1e-12 && known == 2);
        assert_eq!(of([None; 3]).apart(&people, ALL_PEOPLE), None);
        let (apart, _) = of([Some(0.3), None, None]).apart(&people, 1).unwrap();
        assert!(apart.abs() < 1e-12);
        assert_eq!(chosen(None).there(), 1);
    }
}
