//! Who the pedestrian is: how usual a person of its parameters is.

use std::sync::Arc;

use scenario::population::{HUMANS, Plausibility, STANDARD};
use scenario::{Absence, ChoiceOption, Declaration, Dimension, Metric, MetricKind, MetricRange, Parameter};
use scenario::{PedestrianModel, Scope, Settings, Stake, Worst};
use sim::measure::{Encounters, Meter, MetricContext, meters};

pub fn plausibility() -> Metric {
    let declaration = Declaration::new(
        "plausibility",
        "How usual a person of the pedestrian's parameters is: the share of a population that is \
         no more usual, so that 5 % means that 1 in 20 of them is at least as unusual. \
         Undefined for models without individuals, for another variant, and where the scenario \
         gives a parameter another value than its default that the population says nothing of. \
         Measured only where somebody asks for it.",
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
        stake: Stake::Appearance,
        meters: meters(|context| Box::new(KnownBefore::of(context))),
    }
}

/// Nothing in the run changes it, and it is worked out where somebody reads it.
struct KnownBefore {
    population: String,
    /// The pedestrian's, if anybody knows it.
    model: Option<Arc<PedestrianModel>>,
    person: Settings,
}

impl KnownBefore {
    fn of(context: &MetricContext) -> Self {
        let person = &context.world.pedestrians[context.pedestrian].model;
        Self {
            population: context.settings.word("population").to_string(),
            model: person.model.entry().cloned(),
            person: person.settings.clone(),
        }
    }
}

impl Meter for KnownBefore {
    fn value(&self, _: &Encounters) -> Option<f64> {
        let model = &self.model.as_ref()?.declaration;
        Plausibility::of_shipped(&self.population, model)?.tail(model, &self.person)
    }
}
