//! Two objectives against each other: every candidate, and the front of those that no other beats in both.

use super::look::{LegendEntry, Look};
use super::mark::PointMark;
use super::panel::{Axis, AxisQuantity, Panel};
use super::scale::nice_range;
use scenario::Goal;

/// A chart of a Pareto front.
#[derive(Debug, Clone, PartialEq)]
pub struct Front {
    pub title: String,
    pub x: AxisQuantity,
    pub y: AxisQuantity,
    /// Which way each of them is better.
    pub goals: (Goal, Goal),
    /// Both objectives of every candidate that has them; [`PointMark::Best`] ones make up the front.
    pub tried: Vec<(f64, f64, PointMark)>,
}

impl Front {
    pub fn legend(&self) -> Vec<LegendEntry> {
        let mut entries = vec![LegendEntry {
            swatch: Look::series(0).swatch(true, false),
            label: "front: nothing found is better in both".into(),
        }];
        entries.extend(PointMark::legend(self.tried.iter().map(|(_, _, mark)| *mark), "on the front"));
        entries
    }

    pub fn to_svg(&self) -> String {
        let range_of = |pick: fn(&(f64, f64, PointMark)) -> f64| nice_range(self.tried.iter().map(pick));
        let (x, y) = (range_of(|one| one.0), range_of(|one| one.1));
        let labels = (self.x.label(), self.y.label());
        let description = format!("{} against {}", labels.1, labels.0);
        let mut panel =
            Panel::new(&self.title, &description, (&labels.0, &labels.1), Axis::Numbers { range: x }, y);
        panel.line(self.corners(), Look::series(0), "front");
        for mark in PointMark::ALL {
            let tried = self.tried.iter().filter(|(_, _, known)| *known == mark);
            panel.marks(tried.map(|(x, y, _)| (*x, Some(*y))), mark);
        }
        panel.finish()
    }

    /// The edge of what the front beats: from one of its candidates to the next by way of the corner that is worse in
    /// both, for nothing between them is known to be reached.
    fn corners(&self) -> Vec<(f64, f64)> {
        let best = self.tried.iter().filter(|(_, _, mark)| *mark == PointMark::Best);
        let mut front: Vec<(f64, f64)> = best.map(|(x, y, _)| (*x, *y)).collect();
        front.sort_by(|left, right| left.0.total_cmp(&right.0));
        let mut corners = Vec::new();
        for (index, (x, y)) in front.iter().enumerate() {
            if let Some((before_x, before_y)) = index.checked_sub(1).map(|before| front[before]) {
                corners.push(match self.goals.0 {
                    Goal::Minimise => (*x, before_y),
                    Goal::Maximise => (before_x, *y),
                });
            }
            corners.push((*x, *y));
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn front(goals: (Goal, Goal), tried: &[(f64, f64, PointMark)]) -> Front {
        Front {
            title: "braking".into(),
            x: AxisQuantity::new("mean(time_lost)", "s"),
            y: AxisQuantity::new("quantile(5 %, pet)", "s"),
            goals,
            tried: tried.to_vec(),
        }
    }

    #[test]
    fn steps_by_way_of_what_is_worse_in_both() {
        let best = [(3.0, 5.0, PointMark::Best), (1.0, 2.0, PointMark::Best)];
        let little_of_x_and_much_of_y = front((Goal::Minimise, Goal::Maximise), &best);
        assert_eq!(little_of_x_and_much_of_y.corners(), [(1.0, 2.0), (3.0, 2.0), (3.0, 5.0)]);
        let best = [(1.0, 5.0, PointMark::Best), (3.0, 2.0, PointMark::Best)];
        let much_of_both = front((Goal::Maximise, Goal::Maximise), &best);
        assert_eq!(much_of_both.corners(), [(1.0, 5.0), (1.0, 2.0), (3.0, 2.0)]);
        let little_of_both = front((Goal::Minimise, Goal::Minimise), &best);
        assert_eq!(little_of_both.corners(), [(1.0, 5.0), (3.0, 5.0), (3.0, 2.0)]);
    }

    #[test]
    fn draws_candidates_and_front() {
        let tried = [
            (1.0, 2.0, PointMark::Best),
            (3.0, 5.0, PointMark::Best),
            (2.5, 1.5, PointMark::Initial),
            (4.0, 4.0, PointMark::Proposed),
            (0.5, 6.0, PointMark::Refused),
        ];
        let chart = front((Goal::Minimise, Goal::Maximise), &tried);
        insta::assert_snapshot!(chart.to_svg());
        assert!(!front((Goal::Minimise, Goal::Minimise), &[]).to_svg().contains("NaN"));
    }
}
