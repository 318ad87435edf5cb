//! Statistics of the runs of many persons: shares of the persons that were still there, and how much persons differ.

use super::walk::{LOOKED_AT, Walk, Went};
use numbers::summary::{mean, median_of};
use results::{ChosenGap, ChosenGaps, GapCondition, GapMeasure, PeopleAtGaps};

/// s
const LITTLE: f64 = 1.0;

/// The runs of one person in one condition.
pub type PersonsWalks = Vec<Walk>;

/// What persons did in all conditions of `people`, in their order.
pub fn chosen_gaps(people: &PeopleAtGaps, walks: &[Vec<PersonsWalks>]) -> ChosenGaps {
    let each = people.conditions.iter().zip(walks);
    let conditions = each.clone().map(|(_, persons)| chosen_gap(persons)).collect();
    let of = |is_of: &dyn Fn(&GapCondition) -> bool| -> Vec<&Walk> {
        let those = each.clone().filter(|(condition, _)| is_of(condition));
        those.flat_map(|(_, persons)| persons.iter().flatten()).collect()
    };
    let took = |gap: f64| {
        let all = of(&|condition| condition.with_others && condition.gap == gap);
        all.into_iter().filter(|walk| walk.went == Went::InGap(LOOKED_AT))
    };
    let measure = |measure: &GapMeasure| match measure {
        GapMeasure::ShortTaken(before) => short_taken(&of(&|condition| condition.before == *before)),
        GapMeasure::EntryAfterPrevious(gap) => {
            median_of(&took(*gap).filter_map(|walk| walk.after_previous).collect::<Vec<_>>())
        }
        GapMeasure::LittleLeft(gap) => share(took(*gap).map(|walk| Some(walk.left? < LITTLE))),
        GapMeasure::MeanSpeed => {
            mean(&of(&|_| true).into_iter().filter_map(|walk| walk.speed).collect::<Vec<_>>())
        }
        GapMeasure::Collision => share(of(&|_| true).into_iter().map(|walk| Some(walk.was_hit))),
        GapMeasure::SpeedInGap(gap) => {
            median_of(&took(*gap).filter_map(|walk| walk.speed).collect::<Vec<_>>())
        }
        GapMeasure::NeverAcross => {
            share(of(&|_| true).into_iter().map(|walk| Some(walk.went == Went::Never)))
        }
        GapMeasure::StepBack => share(of(&|_| true).into_iter().map(|walk| walk.stepped_back)),
    };
    ChosenGaps { conditions, measures: people.measures.iter().map(|(one, _)| measure(one)).collect() }
}

/// Of the known values; `None` if there are none.
fn share(known: impl Iterator<Item = Option<bool>>) -> Option<f64> {
    let known: Vec<bool> = known.flatten().collect();
    ratio(known.iter().filter(|one| **one).count(), known.len())
}

fn ratio(some: usize, all: usize) -> Option<f64> {
    (all > 0).then(|| some as f64 / all as f64)
}

/// How many of the gaps before the one that is looked at were taken, of those that were offered.
fn short_taken(walks: &[&Walk]) -> Option<f64> {
    let (mut taken, mut offered) = (0, 0);
    for walk in walks {
        match walk.went {
            Went::BeforeFirst => {}
            Went::InGap(gap) if gap < LOOKED_AT => {
                taken += 1;
                offered += gap;
            }
            Went::InGap(_) | Went::Never => offered += LOOKED_AT - 1,
        }
    }
    ratio(taken, offered)
}

fn chosen_gap(persons: &[PersonsWalks]) -> ChosenGap {
    let count =
        |is_it: &dyn Fn(Went) -> bool| persons.iter().flatten().filter(|walk| is_it(walk.went)).count();
    let is_shorter = |went| matches!(went, Went::InGap(gap) if gap < LOOKED_AT);
    let is_there = |went| went != Went::BeforeFirst && !is_shorter(went);
    let takes = |went| went == Went::InGap(LOOKED_AT);
    let of = |walks: &PersonsWalks| {
        let there = walks.iter().filter(|walk| is_there(walk.went)).count();
        (there, walks.iter().filter(|walk| takes(walk.went)).count())
    };
    // Of a model that is one person, runs are all that differs.
    let each: Vec<(usize, usize)> = match persons {
        [only] => only
            .iter()
            .map(|walk| (usize::from(is_there(walk.went)), usize::from(takes(walk.went))))
            .collect(),
        several => several.iter().map(of).collect(),
    };
    let pairs: Vec<f64> = persons.iter().map(of).filter_map(pair_share).collect();
    let (there, taken) = (count(&is_there), count(&takes));
    ChosenGap {
        runs: persons.iter().map(Vec::len).sum(),
        before_first: count(&|went| went == Went::BeforeFirst),
        in_shorter: count(&is_shorter),
        taken,
        share: ratio(taken, there),
        error: standard_error(&each),
        pairs: mean(&pairs),
    }
}

/// The share of pairs of a person's runs in which both hold, of `all` in which the person was there: without bias, k (k - 1) of n (n - 1).
fn pair_share((all, held): (usize, usize)) -> Option<f64> {
    (all > 1).then(|| (held * held.saturating_sub(1)) as f64 / (all * (all - 1)) as f64)
}

/// The standard error of the share of all, a ratio over persons drawn anew: each with how often it was there and how often it held.
/// `None` of fewer than two persons that were there, and where all of them always or never did so.
fn standard_error(persons: &[(usize, usize)]) -> Option<f64> {
    let persons: Vec<(f64, f64)> = persons
        .iter()
        .filter(|(there, _)| *there > 0)
        .map(|(there, held)| (*there as f64, *held as f64))
        .collect();
    let there: f64 = persons.iter().map(|(there, _)| there).sum();
    let held: f64 = persons.iter().map(|(_, held)| held).sum();
    let number = persons.len() as f64;
    let squares: f64 = persons.iter().map(|(all, some)| some - held / there * all).map(|one| one * one).sum();
    let differ = held > 0.0 && held < there;
    (persons.len() > 1 && differ).then(|| (squares * number / (number - 1.0)).sqrt() / there)
}

#[cfg(test)]
mod tests {
    use super::super::facts::{read_people_at_gaps, tests::made_up};
    use super::*;

    fn walk(went: Went) -> Walk {
        Walk {
            went,
            after_previous: None,
            left: None,
            speed: None,
            was_hit: false,
            stepped_back: Some(false),
        }
    }

    fn persons(each: &[&[Went]]) -> Vec<PersonsWalks> {
        each.iter().map(|went| went.iter().copied().map(walk).collect()).collect()
    }

    const TAKES: Went = Went::InGap(LOOKED_AT);
    const SHORT: Went = Went::InGap(2);
    const LATER: Went = Went::InGap(LOOKED_AT + 1);

    #[test]
    fn a_share_is_of_persons_that_were_still_there() {
        let found = chosen_gap(&persons(&[
            &[TAKES, TAKES, Went::BeforeFirst],
            &[SHORT, LATER, TAKES],
            &[Went::Never, LATER, LATER],
        ]));
        assert_eq!((found.runs, found.before_first, found.in_shorter, found.taken), (9, 1, 1, 3));
        assert_eq!((found.there(), found.share), (7, Some(3.0 / 7.0)));
        // Pairs by hand: 2 of 2 times 1, 1 of 2, 0 of 3, so 1, 0 and 0.
        assert_eq!(found.pairs, Some(1.0 / 3.0));
        // Ratio over persons: 2 - 6/7, 1 - 6/7 and 0 - 9/7.
        let squares = (64.0 + 1.0 + 81.0) / 49.0;
        assert!((found.error.unwrap() - (squares * 1.5f64).sqrt() / 7.0).abs() < 1e-12);
    }

    #[test]
    fn without_a_person_that_is_still_there_the_share_is_unknown() {
        let found = chosen_gap(&persons(&[&[Went::BeforeFirst, SHORT], &[SHORT, SHORT]]));
        assert_eq!((found.share, found.error, found.pairs, found.there()), (None, None, None, 0));
        // One run of each person is not a pair, and one person has no spread between persons.
        let found = chosen_gap(&persons(&[&[TAKES, SHORT], &[SHORT, LATER]]));
        assert_eq!((found.share, found.pairs), (Some(0.5), None));
        let found = chosen_gap(&persons(&[&[TAKES, SHORT], &[SHORT, SHORT]]));
        assert_eq!((found.share, found.error), (Some(1.0), None));
        // Two persons that do the same do not show that persons do not differ.
        let found = chosen_gap(&persons(&[&[LATER, LATER], &[Went::Never, LATER]]));
        assert_eq!((found.share, found.error, found.pairs), (Some(0.0), None, Some(0.0)));
    }

    /// A second derivation of the standard error: the deviation of shares among many draws of persons.
    #[test]
    fn the_standard_error_is_the_deviation_of_shares_among_draws_of_persons() {
        let mut stream = numbers::random::Stream::seeded(7);
        let (mut shares, mut errors) = (Vec::new(), Vec::new());
        for _ in 0..2000 {
            let person = |_| {
                // Persons differ, and those that take the gap more often are there less often.
                let takes = stream.uniform() * stream.uniform();
                let there = (0..5).filter(|_| stream.uniform() > 0.5 * takes).count();
                (there, (0..there).filter(|_| stream.uniform() < takes).count())
            };
            let persons: Vec<(usize, usize)> = (0..60).map(person).collect();
            let sum = |of: fn(&(usize, usize)) -> usize| persons.iter().map(of).sum::<usize>() as f64;
            shares.push(sum(|one| one.1) / sum(|one| one.0));
            errors.push(standard_error(&persons).expect("persons differ"));
        }
        let centre = mean(&shares).unwrap();
        let squares: Vec<f64> = shares.iter().map(|one| (one - centre) * (one - centre)).collect();
        let deviation = mean(&squares).unwrap().sqrt();
        let error = mean(&errors).unwrap();
        assert!((error / deviation - 1.0).abs() < 0.06, "{error} and {deviation}");
        let covered =
            shares.iter().zip(&errors).filter(|(share, error)| (*share - centre).abs() <= 1.96 * *error);
        let covered = covered.count() as f64 / shares.len() as f64;
        assert!((0.93..=0.97).contains(&covered), "{covered}");
    }

    #[test]
    fn pairs_have_no_bias() {
        assert_eq!(pair_share((1, 1)), None);
        assert_eq!(pair_share((4, 3)), Some(0.5));
        // A person with a probability of 0.3 takes a gap twice with 0.09, in 2, 3 or 5 runs.
        let probability = 0.3f64;
        for all in [2usize, 3, 5] {
            let chance = |held: usize| {
                let choose: f64 = (0..held).map(|one| (all - one) as f64 / (one + 1) as f64).product();
                choose * probability.powi(held as i32) * (1.0 - probability).powi((all - held) as i32)
            };
            let expected: f64 = (0..=all).map(|held| chance(held) * pair_share((all, held)).unwrap()).sum();
            assert!((expected - 0.09).abs() < 1e-12, "{expected}");
        }
    }

    #[test]
    fn a_model_that_is_one_person_has_errors_of_its_runs() {
        let found = chosen_gap(&persons(&[&[TAKES, TAKES, LATER, LATER]]));
        // Four runs: 0.25 / 3 each, and no differences between persons: 2 of 12 pairs.
        assert!((found.error.unwrap() - (0.25f64 / 3.0).sqrt()).abs() < 1e-12);
        assert_eq!(found.pairs, Some(2.0 / 12.0));
    }

    #[test]
    fn short_gaps_are_of_those_that_were_offered() {
        let walks = [walk(Went::BeforeFirst), walk(SHORT), walk(TAKES), walk(Went::Never)];
        // The second of two, none of three, none of three.
        assert_eq!(short_taken(&walks.iter().collect::<Vec<_>>()), Some(1.0 / 8.0));
        assert_eq!(short_taken(&[&walks[0]]), None);
    }

    #[test]
    fn each_measure_is_of_its_persons() {
        let people = read_people_at_gaps("facts.json", &made_up().to_string()).unwrap();
        let nobody: Vec<PersonsWalks> = persons(&[&[Went::BeforeFirst]]);
        let mut walks = vec![nobody; people.conditions.len()];
        let of = |walks: &[Vec<PersonsWalks>], measure: GapMeasure| {
            let place = people.measures.iter().position(|(one, _)| *one == measure).unwrap();
            chosen_gaps(&people, walks).measures[place]
        };
        // No person took a gap, so that measures of persons that took one are unknown.
        for measure in [
            GapMeasure::EntryAfterPrevious(4.0),
            GapMeasure::LittleLeft(4.0),
            GapMeasure::MeanSpeed,
            GapMeasure::SpeedInGap(4.0),
            GapMeasure::ShortTaken(3.0),
        ] {
            assert_eq!(of(&walks, measure), None, "{measure:?}");
        }
        assert_eq!(of(&walks, GapMeasure::NeverAcross), Some(0.0));
        let takes = |after: f64, left: f64, speed: f64| Walk {
            after_previous: Some(after),
            left: Some(left),
            speed: Some(speed),
            ..walk(TAKES)
        };
        let hit = Walk { was_hit: true, left: Some(0.0), ..walk(TAKES) };
        walks[5] = vec![vec![takes(1.0, 1.2, 1.5), takes(2.0, 0.8, 1.3)], vec![hit, walk(Went::Never)]];
        walks[0] = vec![vec![Walk { stepped_back: Some(true), ..takes(9.0, 0.1, 1.1) }]];
        assert_eq!(of(&walks, GapMeasure::EntryAfterPrevious(4.0)), Some(1.5));
        assert_eq!(of(&walks, GapMeasure::EntryAfterPrevious(6.5)), None);
        // A person that is hit has nothing left.
        assert_eq!(of(&walks, GapMeasure::LittleLeft(4.0)), Some(2.0 / 3.0));
        assert!((of(&walks, GapMeasure::MeanSpeed).unwrap() - 1.3).abs() < 1e-12);
        assert!((of(&walks, GapMeasure::SpeedInGap(4.0)).unwrap() - 1.4).abs() < 1e-12);
        // One each of six conditions, and four.
        assert_eq!(of(&walks, GapMeasure::Collision), Some(1.0 / 10.0));
        assert_eq!(of(&walks, GapMeasure::NeverAcross), Some(1.0 / 10.0));
        assert_eq!(of(&walks, GapMeasure::StepBack), Some(1.0 / 10.0));
    }
}
