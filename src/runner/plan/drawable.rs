//! Whether what a scenario draws can be run: looked at before anything is, at the middle and far out in every distribution.

use super::draws::{OUTERMOST, RunDraws};
use super::error::PlanError;
use super::variables::Variables;
use numbers::distributions::normal;
use scenario::{Individual, Scenario, significant};

/// The farthest that a coordinate can lie out: half a cell of those that streams have.
const FARTHEST: f64 = 0.5 / (1_u64 << 52) as f64;

/// So many rows of a table, or people, are tried at most.
const MOST_OPTIONS: usize = 10_000;

/// With more draws than this not every corner is tried.
const MOST_CORNERS: usize = 6;

/// A trial whose runs are drawn.
#[derive(Clone, Copy)]
pub struct DrawnTrial<'a> {
    pub draws: &'a RunDraws,
    pub scenario: &'a Scenario,
    pub variables: &'a Variables,
    /// Those who are the same in all runs.
    pub fixed: &'a [Individual],
}

/// What lies so far out that it is left out of what is drawn.
#[derive(Debug, Clone, PartialEq)]
pub struct CutOffDraw {
    /// The draw.
    pub name: String,
    /// Where it is declared.
    pub origin: scenario::Origin,
    /// How much of it is left out.
    pub share: f64,
    /// Why that is not possible.
    pub why: String,
}

impl DrawnTrial<'_> {
    /// What of its draws comes to nothing, always to the same, or to a run that is not possible: the first thing. With `everybody` all rows
    /// of tables and all people are looked at.
    pub fn check(self, everybody: bool) -> Result<(), PlanError> {
        let Self { draws, scenario, variables, .. } = self;
        let middle = draws.middle();
        self.tried(&middle)?;
        for axis in 0..draws.len() {
            let (origin, name) = draws.place(scenario, axis);
            if draws.is_constant(scenario, variables, axis) {
                return Err(PlanError::new(
                    origin,
                    format!("`{name}` is the same in every run: nothing is drawn"),
                )
                .with_hint("give it a spread, or say a constant: `let NAME = VALUE`, `individual 17 of …`"));
            }
            match draws.option_shares(scenario, axis) {
                Some(shares) if everybody => self.check_options(axis, &shares)?,
                Some(_) => {}
                None => {
                    for out in [OUTERMOST, 1.0 - OUTERMOST] {
                        self.check_far_out(axis, out)?;
                    }
                }
            }
        }
        if everybody { self.check_together() } else { Ok(()) }
    }

    fn tried(self, point: &[f64]) -> Result<(), PlanError> {
        let Self { draws, scenario, variables, fixed } = self;
        draws.at(scenario, variables, fixed, point).map(|_| ())
    }

    /// With one coordinate there, the others in the middle.
    fn tried_at(self, axis: usize, share: f64) -> Result<(), PlanError> {
        let mut point = self.draws.middle();
        point[axis] = share;
        self.tried(&point)
    }

    fn check_options(self, axis: usize, shares: &[f64]) -> Result<(), PlanError> {
        for share in shares.iter().step_by(shares.len() / MOST_OPTIONS + 1) {
            let Err(error) = self.tried_at(axis, *share) else { continue };
            let (origin, name) = self.draws.place(self.scenario, axis);
            let mut point = self.draws.middle();
            point[axis] = *share;
            let drawn = self.draws.values(self.scenario, &mut self.variables.clone(), &point);
            let drawn = drawn.map(|(drawn, _)| drawn).unwrap_or_default();
            let of_axis = drawn.iter().filter(|one| one.share == *share);
            let words: Vec<_> = of_axis.map(|one| format!("{}={}", one.name, one.label)).collect();
            let message =
                format!("`{name}` may come to {}, which cannot be run: {}", words.join(", "), error.message);
            return Err(PlanError::new(origin, message).with_hint("leave it out of what is drawn"));
        }
        Ok(())
    }

    /// The share that lies beyond what is possible, between a coordinate that is not and the middle, and what is wrong there.
    fn beyond(self, axis: usize, out: f64, inside: f64) -> f64 {
        let (mut impossible, mut possible) = (out, inside);
        for _ in 0..50 {
            // In equal steps of how rare it is.
            let middle = if possible < 0.5 || impossible < 0.5 {
                (impossible * possible).sqrt()
            } else {
                1.0 - ((1.0 - impossible) * (1.0 - possible)).sqrt()
            };
            match self.tried_at(axis, middle) {
                Ok(()) => possible = middle,
                Err(_) => impossible = middle,
            }
        }
        impossible.min(1.0 - impossible)
    }

    fn check_far_out(self, axis: usize, out: f64) -> Result<(), PlanError> {
        let Err(error) = self.tried_at(axis, out) else { return Ok(()) };
        let share = self.beyond(axis, out, 0.5);
        let (origin, name) = self.draws.place(self.scenario, axis);
        let message =
            format!("{} of what `{name}` comes to cannot be run: {}", percent(share), error.message);
        Err(PlanError::new(origin, message).with_hint(
            "cut it where that begins: `truncated_normal(mean, standard deviation, low, high)`; `uniform`, `triangular` and `beta` have \
             ends as well",
        ))
    }

    /// Several draws somewhat far out each, together as rare as one of them far out: as if they were normal, where a plane so far from the
    /// middle has just [`OUTERMOST`] behind it.
    fn check_together(self) -> Result<(), PlanError> {
        let draws = self.draws;
        let axes: Vec<usize> =
            (0..draws.len()).filter(|axis| draws.option_shares(self.scenario, *axis).is_none()).collect();
        let radius = -normal::quantile(OUTERMOST);
        let mut groups: Vec<Vec<usize>> = Vec::new();
        for (place, one) in axes.iter().enumerate() {
            groups.extend(axes[place + 1..].iter().map(|other| vec![*one, *other]));
        }
        if (3..=MOST_CORNERS).contains(&axes.len()) {
            groups.push(axes);
        }
        for group in groups {
            let distance = radius / (group.len() as f64).sqrt();
            for signs in 0..1_u32 << group.len() {
                let mut point = draws.middle();
                for (bit, axis) in group.iter().enumerate() {
                    let z = if signs >> bit & 1 == 0 { -distance } else { distance };
                    point[*axis] = normal::cumulative(z);
                }
                if let Err(error) = self.tried(&point) {
                    let names: Vec<_> = group
                        .iter()
                        .map(|axis| format!("`{}`", draws.place(self.scenario, *axis).1))
                        .collect();
                    let (origin, _) = draws.place(self.scenario, group[0]);
                    let message = format!(
                        "what {} come to together cannot always be run: {}",
                        names.join(" and "),
                        error.message
                    );
                    return Err(PlanError::new(origin, message).with_hint(
                        "cut them where that begins: `truncated_normal(mean, standard deviation, low, high)`",
                    ));
                }
            }
        }
        Ok(())
    }

    /// What is left out of the draws, less than [`OUTERMOST`] at each end of each.
    pub fn cut_off(self) -> Vec<CutOffDraw> {
        let mut found = Vec::new();
        for axis in 0..self.draws.len() {
            if self.draws.option_shares(self.scenario, axis).is_some() {
                continue;
            }
            for (out, inside) in [(FARTHEST, OUTERMOST), (1.0 - FARTHEST, 1.0 - OUTERMOST)] {
                let Err(error) = self.tried_at(axis, out) else { continue };
                let (origin, name) = self.draws.place(self.scenario, axis);
                let share = self.beyond(axis, out, inside);
                let (name, origin) = (name.to_string(), origin.clone());
                found.push(CutOffDraw { name, origin, share, why: error.message });
            }
        }
        found
    }
}

fn percent(share: f64) -> String {
    format!("{} %", significant(100.0 * share, 2))
}
