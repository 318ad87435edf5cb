//! The checked scenario and suite: data in SI units, and what they refer to.
//!
//! [`Suite`] and [`Scenario`] are what a user declared; values may still be [`Expression`]s over variations.
//! [`Case`] is one concrete run, every expression evaluated. [`Declaration`] is how models, controllers and metrics
//! describe themselves to the checker, the documentation and the optimiser. What a scenario names it holds, as a
//! [`Reference`] to the entry that a registry gave: nobody below looks a name up again. [`agent`] has the seams that
//! such entries plug into.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

pub mod agent;
mod aggregate;
mod approach;
mod attention;
mod block;
mod calibrate;
mod case;
mod comparison;
mod conflict;
mod conflict_area;
mod criterion;
mod declaration;
mod declared;
mod declared_bend;
mod declared_road;
mod dimension;
mod direction;
mod distribution;
mod draw;
mod draw_tail;
mod entry;
mod estimate;
mod evaluate;
mod expression;
mod expressions;
mod gate;
pub mod geometry;
mod ground;
mod individuals;
mod known_distribution;
pub mod limits;
mod metric;
mod notation;
mod observations;
mod optimisation;
mod origin;
mod path;
mod path_conflict;
mod placed;
mod placement;
pub mod population;
mod program;
mod program_fault;
mod rating;
mod reference;
pub mod registry;
mod road;
mod road_user_kind;
mod signal;
mod signal_conduct;
mod statement;
mod stream;
mod symbol;
mod traffic_signal;
mod trial;
mod value;
mod varied_value;
mod world;

pub use agent::CommandKind;
pub use aggregate::{AGGREGATES, Aggregate, AggregateBounds, AggregateOf, AggregateResponse, AggregateWord};
pub use approach::Approach;
pub use attention::{Attention, LooksAt};
pub use block::Block;
pub use calibrate::{Calibrate, CandidateSource, MatchedParameter, MatchedRate, ParameterStatistic};
pub use case::{Assignment, Case, Individual};
pub use comparison::{Comparison, MetricReference, Relation, WhenUndefined, constant};
pub use conflict::{Conflict, half_extent};
pub use conflict_area::{ConflictArea, Stretch};
pub use criterion::{Claim, Criterion, People, Reach, VariationCondition};
pub use declaration::{
    ANOTHER_MODEL, Chance, ChoiceOption, Declaration, Departure, Parameter, ParameterKind, Preset,
    PresetFamily, Published, SettingError, Text, TextCheck, TextError,
};
pub use declared::{
    DeclaredAppearance, DeclaredFollowing, DeclaredMayGo, DeclaredPedestrian, DeclaredPlace, DeclaredShape,
    DeclaredVehicleStart, Membership, Model, REAR_AXLE, RunBudget, Samples, SamplingScheme, Scenario, Suite,
    TestedInstead, TextDigest, Variation, Vehicle, WalksAlong, sha256,
};
pub use declared_bend::{BendRadius, DeclaredBend, DeclaredPiece, PieceKind, WIDE};
pub use declared_road::DeclaredOtherRoad;
pub use dimension::Dimension;
pub use direction::{Direction, Side};
pub use distribution::{
    DISTRIBUTIONS, Distribution, DistributionError, DistributionOf, DistributionWord, NumberOf,
};
pub use draw::{DeclaredDraw, Draw, DrawSource, DrawTable};
pub use entry::{
    AT_THE_CROSSING, BuildController, BuildDynamics, BuildPedestrian, BuildPerception, CROSSES,
    ControllerContext, ControllerModel, DynamicsModel, KeepsOff, LookEffect, ModelSetup, PedestrianContext,
    PedestrianModel, PedestrianSetup, PerceptionModel, VehicleSetup, World,
};
pub use estimate::{
    Estimate, EstimateClaim, EstimateClaimOf, EstimateMethod, Exposure, FEWEST_ESTIMATE_RUNS,
};
pub use evaluate::{Condition, Evaluate, Measure, ParameterSet};
pub use expression::{BinaryOperator, EvaluationError, Expression};
pub use gate::{Gate, GateRate, GateRule, Tolerance};
pub use ground::{DeclaredGround, GRAVITY, Ground};
pub use individuals::{Individuals, PopulationShare};
pub use known_distribution::{DrawnValue, KnownDistribution, at_share};
pub use metric::{Absence, Meters, Metric, MetricKind, MetricRange, Scope, Stake, Worst};
pub use notation::{Notation, Written, out_of_range, show, show_apart, show_both, show_outside};
pub use observations::{ObservationError, Observations, ObservedErrors, ObservedRow};
pub use optimisation::{
    Budget, CaseSet, Goal, InitialDesign, Keep, Objective, Part, RangeValues, SampleSize, Search,
    SearchMethod, SearchRange, ShownIn, Target, Tune,
};
pub use origin::Origin;
pub use path::{Located, Path};
pub use path_conflict::PathConflict;
pub use placement::{Appearance, MayGo, Position, Shape, VehicleReference, VehicleStart};
pub use program::{Answer, DeclaredFmu, DeclaredProgram, Delay, ProgramKind, WiredVariable};
pub use program_fault::{FaultKind, ProgramFault};
pub use rating::{PointsCriterion, Rating, Scoring, TagPoints, Weight, WeightedValues, Weights};
pub use reference::{Reference, Registered};
pub use road::{Bend, Body, Crossing, CrossingKind, Lane, Median, OtherCrossing, Road};
pub use road_user_kind::RoadUserKind;
pub use signal::{NOBODY_AT, OBJECT, OBJECTS, SEEN, STEERS, SignalEntry, input_signals, output_signals};
pub use signal_conduct::SignalConduct;
pub use statement::{
    DeclaredStanding, Measured, OutcomesOf, Quantity, Statement, StatementClaim, StatementClaimKind,
    TrendDirection,
};
pub use stream::{DeclaredStream, FurtherGaps, StreamError, TrafficStream};
pub use symbol::Symbol;
pub use traffic_signal::{DeclaredSignal, STOP_LINE, SeenSignal, SignalError, SignalState, TrafficSignal};
pub use trial::{Rounds, Trial};
pub use value::{Settings, Value, significant};
pub use varied_value::VariedValue;
