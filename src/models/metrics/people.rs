//! Who the pedestrian is: how usual a person of its parameters is.

use std::sync::LazyLock;

use crate::pedestrian::commotions::model::commotions;
use scenario::population::{HUMANS, Plausibility, Population, STANDARD};
use scenario::{Absence, ChoiceOption, Declaration, Dimension, Metric, MetricKind, MetricRange, Parameter};
use scenario::{Scope, Worst};
use sim::measure::{Encounters, Meter, MetricContext, meters};

pub fn plausibility() -> Metric {
    let declaration = Declaration::new(
        "plausibility",
        "How usual a person of the pedestrian's parameters is: the share of a population that is \
         no more usual, so that 5 % means that 1 in 20 of them is at least as unusual. \
         Undefined for models without individuals, for another variant, and where the scenario \
         gives a parameter another value than its default that the population says nothing of.",
    )
    .source(
        "tail quantile of a kernel density of the logarithms of the parameters, over the weighted members; \
         width of Silverman 1986, section 4.3.2",
    )
    .parameters([Parameter::choice(
        "population",
        HUMANS,
        [
            ChoiceOption::new(HUMANS, "who do what people did in an experiment"),
            ChoiceOption::new(STANDARD, "who meet the published criteria"),
        ],
        "The population that ships and that the person is held against.",
        "docs/populations.md",
    )])
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::NUMBER),
        scope: Scope::Pedestrian,
        worst: Worst::Smallest,
        absence: Absence::Open,
        range: MetricRange::Share,
        meters: meters(|context| Box::new(KnownBefore(usual(context)))),
    }
}

/// It is known before the run, and nothing in it changes it.
struct KnownBefore(Option<f64>);

impl Meter for KnownBefore {
    fn value(&self, _: &Encounters) -> Option<f64> {
        self.0
    }
}

fn usual(context: &MetricContext) -> Option<f64> {
    static OF_HUMANS: LazyLock<Option<Plausibility>> = LazyLock::new(|| of(HUMANS));
    static OF_STANDARD: LazyLock<Option<Plausibility>> = LazyLock::new(|| of(STANDARD));
    let person = &context.world.pedestrians[context.pedestrian].model;
    let model = person.model.known()?;
    let population = if context.settings.word("population") == HUMANS { &OF_HUMANS } else { &OF_STANDARD };
    population.as_ref()?.tail(&model.declaration, &person.settings)
}

fn of(name: &str) -> Option<Plausibility> {
    let population = Population::parse(name, None, &commotions().declaration, None).ok()?;
    Plausibility::of(&population)
}
