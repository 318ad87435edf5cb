//! What is measured in every run.

use serde::{Deserialize, Serialize};

use scenario::registry::{Registry, UnknownEntry};
use scenario::{Criterion, MetricReference};

/// The metrics that are read off every run of a suite: each with its defaults, and what criteria ask for besides.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Requests(Vec<MetricReference>);

impl Requests {
    /// Every registered metric with its defaults, but for those that are measured on request.
    pub fn defaults(registry: &Registry) -> Self {
        let usual = registry.metrics().iter().filter(|metric| !metric.declaration.on_request);
        Self(usual.map(MetricReference::plain).collect())
    }

    /// Adds whatever the criteria need that is not there yet.
    pub fn include(&mut self, criteria: &[Criterion]) {
        criteria.iter().for_each(|criterion| self.add(criterion.claim.metric()));
    }

    /// Adds a metric unless it is there already. One of a group that has other members in another scenario is one metric: of
    /// every member that is there.
    pub fn add(&mut self, reference: &MetricReference) {
        match self.index(reference) {
            Some(index) => self.0[index].join(reference),
            None => self.0.push(reference.clone()),
        }
    }

    /// Those that are among the asked, in the same order.
    #[must_use]
    pub fn only(&self, asked: &Self) -> Self {
        Self(self.0.iter().filter(|known| asked.index(known).is_some()).cloned().collect())
    }

    /// The place of this metric's value in every outcome; `None` if it is not measured.
    pub fn index(&self, reference: &MetricReference) -> Option<usize> {
        self.0.iter().position(|known| known.is_same(reference))
    }

    /// In order, to be changed in place; how many they are stays.
    pub fn iter_mut(&mut self) -> impl Iterator<Item = &mut MetricReference> {
        self.0.iter_mut()
    }

    /// In the order of the values of every outcome.
    pub fn iter(&self) -> impl Iterator<Item = &MetricReference> {
        self.0.iter()
    }

    /// The same, with all metrics resolved: of those that were read, only the names are known.
    ///
    /// # Errors
    /// The first metric that the registry does not have.
    pub fn resolved(mut self, registry: &Registry) -> Result<Self, UnknownEntry> {
        self.0.iter_mut().try_for_each(|request| registry.resolve_metric(request))?;
        Ok(self)
    }

    /// In the order of the values of every outcome.
    pub fn as_slice(&self) -> &[MetricReference] {
        &self.0
    }
}
