//! How bad encounters are against how usual they are: every one that was evaluated, and the front of those such that none that is at least
//! as usual is worse.

use super::look::{LegendEntry, Look};
use super::mark::PointMark;
use super::panel::{Axis, AxisQuantity, Panel, Rule};
use super::scale::nice_range;
use scenario::Goal;

/// A chart of danger against plausibility. Across is how rare encounters are, on a logarithmic scale: one in so many is at least as unusual.
#[derive(Debug, Clone, PartialEq)]
pub struct Danger {
    pub title: String,
    pub y: AxisQuantity,
    /// Which values are worse.
    pub goal: Goal,
    /// Every evaluated encounter: one in how many is at least as unusual, at least 1, and the objective.
    pub tried: Vec<(f64, f64, PointMark)>,
    /// The worst first.
    pub front: Vec<OnFront>,
    /// Bounds of what is kept: of the objective, and of how rare an encounter may be.
    pub rules: Vec<Rule>,
    pub rarest: Option<f64>,
}

/// An encounter on the front.
#[derive(Debug, Clone, PartialEq)]
pub struct OnFront {
    /// One in so many is at least as unusual.
    pub one_in: f64,
    pub value: f64,
    /// What is said when it is pointed at.
    pub title: String,
    /// Where on the page it stands: `#front-1`.
    pub target: String,
}

impl Danger {
    pub fn legend(&self) -> Vec<LegendEntry> {
        let worse = if self.goal == Goal::Minimise { "below" } else { "above" };
        let mut entries = vec![LegendEntry {
            swatch: Look::series(0).swatch(true, false),
            label: format!("front: nothing found lies {worse} it that is at least as usual"),
        }];
        let marks = self.tried.iter().map(|one| one.2).chain(self.front.iter().map(|_| PointMark::Best));
        entries.extend(PointMark::legend(marks, "on the front; leads to its line below"));
        entries
    }

    pub fn to_svg(&self) -> String {
        let values = self.tried.iter().map(|one| one.1).chain(self.front.iter().map(|one| one.value));
        let rarest = self.tried.iter().map(|one| one.0).chain(self.rarest).fold(1.0, f64::max);
        let (across, y) = ((0.9, (1.3 * rarest).max(10.0)), nice_range(values));
        let labels = ("one in so many encounters is at least as unusual", self.y.label());
        let description = format!("{} against how rare encounters are", labels.1);
        let axis = Axis::Logarithmic { range: across };
        let mut panel = Panel::with_links(&self.title, &description, (labels.0, &labels.1), axis, y);
        self.rules.iter().for_each(|rule| panel.rule(rule));
        if let Some(rarest) = self.rarest.filter(|one| (across.0..=across.1).contains(one)) {
            panel.upright(rarest, "kept", "rule");
        }
        for mark in PointMark::ALL {
            let tried = self.tried.iter().filter(|one| one.2 == mark);
            panel.marks(tried.map(|(x, y, _)| (*x, Some(*y))), mark);
        }
        panel.line(self.corners(across.1), Look::series(0), "front");
        for one in &self.front {
            panel.link((one.one_in, one.value), PointMark::Best, &one.title, &one.target);
        }
        panel.finish()
    }

    /// The worst that was found among encounters that are at least as usual: from the most usual one on it stays until a rarer one is worse.
    fn corners(&self, end: f64) -> Vec<(f64, f64)> {
        let mut corners: Vec<(f64, f64)> = Vec::new();
        for one in self.front.iter().rev() {
            if let Some((_, before)) = corners.last().copied() {
                corners.push((one.one_in, before));
            }
            corners.push((one.one_in, one.value));
        }
        if let Some((_, last)) = corners.last().copied() {
            corners.push((end, last));
        }
        corners
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn chart() -> Danger {
        let on = |one_in: f64, value: f64, number: usize| OnFront {
            one_in,
            value,
            title: format!("pet {value} s, 1 in {one_in}"),
            target: format!("#front-{number}"),
        };
        Danger {
            title: "closest <one>".into(),
            y: AxisQuantity::new("mean(pet)", "s"),
            goal: Goal::Minimise,
            tried: vec![
                (1.2, 3.0, PointMark::Initial),
                (30.0, 2.5, PointMark::Proposed),
                (4.0, 1.5, PointMark::Proposed),
                (400.0, 0.2, PointMark::Proposed),
            ],
            front: vec![on(400.0, 0.2, 1), on(4.0, 1.5, 2), on(1.2, 3.0, 3)],
            rules: vec![Rule { value: 1.5, label: "< 1.5 s".into() }],
            rarest: Some(20.0),
        }
    }

    #[test]
    fn the_front_is_the_worst_that_is_as_usual() {
        let corners = [(1.2, 3.0), (4.0, 3.0), (4.0, 1.5), (400.0, 1.5), (400.0, 0.2), (520.0, 0.2)];
        assert_eq!(chart().corners(520.0), corners);
    }

    #[test]
    fn draws_encounters_and_front() {
        let svg = chart().to_svg();
        assert!(!svg.contains("<one>") && !svg.contains("NaN"), "{svg}");
        assert_eq!(svg.matches("<a href=\"#front-").count(), 3);
        insta::assert_snapshot!(svg);
        let nothing = Danger { tried: Vec::new(), front: Vec::new(), rarest: None, ..chart() };
        assert!(!nothing.to_svg().contains("NaN") && !nothing.to_svg().contains("inf"));
    }
}
