//! What came of runs against what was drawn for them.

use std::collections::BTreeMap;

use super::super::chart::{AxisQuantity, First, FoundDot, IndividualsChart, first_legend};
use super::super::variable::common_unit;
use super::{Data, Figure, charted, thin_out};
use results::TrialReport;
use scenario::Assignment;

/// More draws than this are not told apart in one page.
const MOST_DRAWS: usize = 6;

impl Data<'_> {
    /// A metric of each run against each number that was drawn for it, by scenario.
    pub(super) fn drawn(&self, index: usize) -> Option<Figure> {
        let mut charts = Vec::new();
        let mut left_out = 0;
        for (name, trials) in &self.scenarios {
            let mut names: Vec<&str> = Vec::new();
            for one in trials.iter().flat_map(|trial| &trial.outcomes).flat_map(|outcome| &outcome.drawn) {
                // A person's number says nothing by its size.
                if !one.name.contains('.')
                    && one.value.as_number().is_some()
                    && !names.contains(&one.name.as_str())
                {
                    names.push(&one.name);
                }
            }
            for drawn in names.into_iter().take(MOST_DRAWS) {
                charts.extend(self.against(name, trials, drawn, index, &mut left_out));
            }
        }
        if charts.is_empty() {
            return None;
        }
        let firsts = charts.iter().flat_map(|chart| &chart.points).map(|point| point.first);
        let legend = first_legend(firsts.collect::<Vec<First>>(), false);
        let quantity = self.quantity(index).name;
        let mut note = "One mark per run, at the value that was drawn for it.".to_string();
        if left_out > 0 {
            note += &format!(" {left_out} runs in the middle of their values are not drawn.");
        }
        let panels = charts.iter().map(IndividualsChart::to_svg).collect();
        Some(Figure { title: format!("{quantity} against what was drawn"), note, legend, panels })
    }

    fn against(
        &self,
        scenario: &str,
        trials: &[&TrialReport],
        drawn: &str,
        index: usize,
        left_out: &mut usize,
    ) -> Option<IndividualsChart> {
        let metric = self.reference(index).known()?;
        let unit = self.notation(index);
        let mut values: BTreeMap<usize, Assignment> = BTreeMap::new();
        let runs: Vec<_> = trials.iter().flat_map(|trial| &trial.outcomes).collect();
        for (place, outcome) in runs.iter().enumerate() {
            let value = outcome.drawn.iter().find(|one| one.name == drawn);
            values.extend(value.map(|one| {
                let (name, label) = (one.name.clone(), one.label.clone());
                (place, Assignment { name, label, value: one.value.clone() })
            }));
        }
        let (written, size) = common_unit(&values.values().collect::<Vec<_>>()).unwrap_or_default();
        let size = if size == 0.0 { 1.0 } else { size };
        let point = |(place, value): (&usize, &Assignment)| {
            let outcome = runs[*place];
            let (x, y) = (value.value.as_number()? / size, charted(outcome, index, unit)?);
            Some(FoundDot { x, y, first: self.first(outcome), name: outcome.key.clone(), is_run: true })
        };
        let mut points: Vec<FoundDot> = values.iter().filter_map(point).collect();
        if points.is_empty() {
            return None;
        }
        *left_out += thin_out(&mut points, metric.worst);
        Some(IndividualsChart {
            title: scenario.to_string(),
            x: AxisQuantity::new(drawn, written),
            y: self.quantity(index),
            points,
            courses: Vec::new(),
            rules: self.rules(trials, index),
            ranges: None,
            logarithmic: false,
        })
    }
}
