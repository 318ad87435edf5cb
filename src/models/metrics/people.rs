//! Who the pedestrian is: how usual a person of its parameters is.

use std::sync::OnceLock;

use scenario::population::{HUMANS, Plausibility, Population, STANDARD};
use scenario::{Absence, ChoiceOption, Declaration, Dimension, Metric, MetricKind, MetricRange, Parameter};
use scenario::{Scope, Worst};
use sim::measure::{Encounters, Meter, MetricContext, meters};

pub fn plausibility() -> Metric {
    let known = Shipped::default();
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
        meters: meters(move |context| Box::new(KnownBefore(known.of(context)))),
    }
}

/// What is known of the populations that ship, worked out when the first run asks.
#[derive(Default)]
struct Shipped {
    humans: OnceLock<Option<Plausibility>>,
    standard: OnceLock<Option<Plausibility>>,
}

impl Shipped {
    fn of(&self, context: &MetricContext) -> Option<f64> {
        let person = &context.world.pedestrians[context.pedestrian].model;
        let model = &person.model.known()?.declaration;
        let name = context.settings.word("population");
        let known = if name == HUMANS { &self.humans } else { &self.standard };
        if known.get().is_none() {
            // A model that knows no such people leaves them to the one that does.
            let population = Population::parse(name, None, model, None).ok()?;
            known.get_or_init(|| Plausibility::of(&population));
        }
        known.get()?.as_ref()?.tail(model, &person.settings)
    }
}

/// It is known before the run, and nothing in it changes it.
struct KnownBefore(Option<f64>);

impl Meter for KnownBefore {
    fn value(&self, _: &Encounters) -> Option<f64> {
        self.0
    }
}
