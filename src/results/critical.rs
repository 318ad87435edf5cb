//! When and for whom metrics took their values.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

/// What is known of some of a run's metrics, by their index; small where there is little.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ByMetric<T>(Box<[(usize, T)]>);

impl<T> ByMetric<T> {
    /// What is known of the metric of this index.
    pub fn get(&self, index: usize) -> Option<&T> {
        self.0.iter().find(|(known, _)| *known == index).map(|(_, value)| value)
    }

    /// What is known, with the indices of the metrics.
    pub(super) fn known(&self) -> &[(usize, T)] {
        &self.0
    }

    /// Whether nothing is known of any metric.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(super) fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        self.0 = std::mem::take(&mut self.0).into_iter().filter(|(index, _)| keep(*index)).collect();
    }
}

impl<T> Default for ByMetric<T> {
    fn default() -> Self {
        Self(Box::default())
    }
}

/// With the indices of the metrics.
impl<T> FromIterator<(usize, T)> for ByMetric<T> {
    fn from_iter<I: IntoIterator<Item = (usize, T)>>(known: I) -> Self {
        Self(known.into_iter().collect())
    }
}

/// Of each metric in order, where there is something.
impl<T> FromIterator<Option<T>> for ByMetric<T> {
    fn from_iter<I: IntoIterator<Item = Option<T>>>(values: I) -> Self {
        let values = values.into_iter().enumerate();
        Self(values.filter_map(|(index, value)| Some((index, value?))).collect())
    }
}

/// The critical instant of a metric in a run.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Critical {
    /// When it took its value, s; `None` for what has no single instant, such as a time lost.
    pub time: Option<f64>,
    /// Whose value it is: a vehicle's, a stream's, a pedestrian's or a pair's.
    pub vehicle: Option<Arc<str>>,
    /// The pedestrian's name; `None` for a metric of vehicles.
    pub pedestrian: Option<Arc<str>>,
    /// Another vehicle or a box that the vehicle touches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other: Option<Arc<str>>,
}
