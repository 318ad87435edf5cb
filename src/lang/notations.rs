//! In which units a suite compares its metrics: what reports show them in.

use super::syntax::ast::{self, View};
use super::syntax::{self, Node};
use super::units::{self, UnitEntry};
use scenario::{Aggregate, Criterion, Dimension, MetricKind, MetricReference, Notation, Suite};

/// Every metric that is compared in another unit than the SI unit, once, with the first such unit: that of a criterion, then of a
/// gate's rule, then of a rating, then of a block.
pub fn of(suite: &Suite) -> Vec<(MetricReference, Notation)> {
    let mut found: Vec<(MetricReference, Notation)> = Vec::new();
    let mut take = |metric: &MetricReference, notation: &dyn Fn() -> Option<Notation>| {
        if !found.iter().any(|(known, _)| known == metric) {
            found.extend(notation().map(|notation| (metric.clone(), notation)));
        }
    };
    for criterion in suite.scenarios.iter().chain(&suite.supporting).flat_map(|scenario| &scenario.criteria) {
        take(criterion.claim.metric(), &|| of_criterion(criterion));
    }
    for rule in suite.gates.iter().flat_map(|gate| &gate.rules) {
        if let Some(about) = &rule.metric {
            take(about, &|| rule.notation);
        }
    }
    for rating in &suite.ratings {
        take(&rating.measure, &|| rating.notation);
    }
    // Of a rate, the notation would be that of a share.
    let of_values = |aggregate: &Aggregate| !matches!(aggregate, Aggregate::Rate(_) | Aggregate::Count(_));
    for search in &suite.searches {
        search.kept_metrics().for_each(|(keep, written_in)| take(&keep.metric, &|| written_in));
        for criterion in &search.expect {
            take(criterion.claim.metric(), &|| of_criterion(criterion));
        }
    }
    for tune in &suite.tunes {
        for (index, constraint) in tune.constraints.iter().enumerate() {
            take(&constraint.metric, &|| tune.constraint_in(index));
        }
    }
    let measures = suite.evaluates.iter().flat_map(|evaluate| &evaluate.measures);
    for measure in measures.filter(|measure| of_values(&measure.aggregate)) {
        take(measure.aggregate.metric(), &|| measure.notation);
    }
    found
}

/// The unit that a criterion is written with, if it compares a quantity.
pub fn of_criterion(criterion: &Criterion) -> Option<Notation> {
    match criterion.claim.metric().known().map(|metric| &metric.kind) {
        Some(MetricKind::Quantity(dimension)) => unit_in(&criterion.text, *dimension),
        _ => None,
    }
}

/// The unit of that dimension that a criterion is written with: `km/h` in `impact_speed <= 20 km/h`.
pub fn unit_in(criterion: &str, dimension: Dimension) -> Option<Notation> {
    let tree = syntax::criterion(criterion)?;
    let mut units = tree.root().every::<ast::Unit>().filter_map(|unit| units::unit_of(unit.text()));
    units.find(|unit| unit.dimension == dimension).map(UnitEntry::notation)
}

/// The unit in which a claim says what is measured, given the SI unit of that: `km/h` in `mean(impact_speed) of all <= 20 km/h`.
pub fn unit_in_claim(claim: &str, si: &str) -> Option<Notation> {
    /// Outside of what is measured, where it would be that of a condition or of a metric's setting.
    fn units(node: Node) -> Vec<UnitEntry> {
        match (ast::Measured::cast(node), ast::Unit::cast(node)) {
            (Some(_), _) => Vec::new(),
            (_, Some(unit)) => units::unit_of(unit.text()).into_iter().collect(),
            _ => node.children().flat_map(units).collect(),
        }
    }
    let tree = syntax::claim(claim)?;
    units(tree.root()).into_iter().find(|unit| unit.dimension.si_unit() == si).map(UnitEntry::notation)
}
