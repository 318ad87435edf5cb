//! The checked scenario and suite: plain data in SI units, without text or behaviour.
//!
//! [`Suite`] and [`Scenario`] are what a user declared; values may still be [`Expression`]s over variations.
//! [`Case`] is one concrete run, every expression evaluated. [`Declaration`] is how models, controllers and metrics
//! describe themselves to the checker, the documentation and the optimiser.

mod block;
mod case;
mod criterion;
mod declaration;
mod declared;
mod dimension;
mod distribution;
mod evaluate;
mod expression;
mod gate;
pub mod limits;
mod notation;
mod optimisation;
mod road;
mod statement;
mod symbol;
mod trial;
mod value;

pub use block::Block;
pub use case::{
    Appearance, Assignment, Case, Individual, ModelSetup, PedestrianSetup, Position, Shape, VehicleReference,
    VehicleSetup, VehicleStart, World,
};
pub use criterion::{
    Aggregate, Claim, Comparison, Criterion, MetricReference, Origin, People, Reach, Relation,
    VariationCondition, WhenUndefined, constant,
};
pub use declaration::{
    ANOTHER_MODEL, Chance, ChoiceOption, Declaration, Departure, Literal, Parameter, ParameterKind, Preset,
    PresetFamily, Published, SettingError, TextCheck, TextError,
};
pub use declared::{
    DeclaredAppearance, DeclaredShape, DeclaredVehicleStart, Individuals, Model, Pedestrian, Population,
    RunBudget, Samples, SamplingScheme, Scenario, Suite, Variation, VariedValue, Vehicle,
};
pub use dimension::Dimension;
pub use distribution::{Distribution, DistributionError, KnownDistribution};
pub use evaluate::{Condition, Evaluate, Measure, ParameterSet};
pub use expression::{BinaryOperator, EvaluationError, Expression};
pub use gate::{Gate, GateRule, Tolerance};
pub use notation::{Notation, Written, out_of_range, show, show_apart, show_both, show_outside};
pub use optimisation::{
    Budget, CaseSet, Goal, InitialDesign, Method, Objective, Part, Range, RangeValues, SampleSize, Search,
    ShownIn, Target, Tune,
};
pub use road::{Body, Crossing, CrossingKind, Direction, Lane, Road, Side};
pub use statement::{
    Measured, OutcomesOf, Quantity, Standing, Statement, StatementClaim, StatementClaimKind, TrendDirection,
};
pub use symbol::Symbol;
pub use trial::{Rounds, Trial};
pub use value::{Settings, Value, significant};
