//! The COMMOTIONS road-user model: a person who perceives with noise, weighs what the other may do, and acts when the evidence suffices.
//!
//! Source: Markkula et al., "Explaining human interactions on the road by large-scale integration of
//! computational psychological theory", PNAS Nexus 2(6), 2023. The numbered sections named in this
//! folder ("§6") are those of the project's mathematical restatement of the model.
//!
//! One [`CommotionsAgent`] watches one other road user, or several, and is stepped by the published states of all. It serves as
//! a pedestrian (speed controlled) and as the driver of a vehicle (acceleration controlled), so two of
//! them can meet. Data goes one way through the files:
//!
//! ```text
//! of each other: perception ─▶ behaviour (what the other may do) ─▶ prediction ─▶ access ─▶ value (sums, looming) ─▶ belief
//! of whoever constrains most: decision ─▶ action
//! ```

pub mod access;
pub mod action;
pub mod affordance;
pub mod agent;
pub mod belief;
pub mod decision;
pub mod draws;
pub mod encounter;
mod following;
pub mod held_back;
pub mod hiker;
pub mod laboratories;
pub mod looming;
pub mod meeting;
pub mod model;
pub mod other;
pub mod parameters;
pub mod perception;
pub mod prediction;
#[cfg(test)]
mod sampled;
pub mod squash;
pub mod state;
pub mod sums;
pub mod timing;
pub mod value;
pub mod variant;

pub use agent::{AgentDecision, AgentEncounter, CommotionsAgent, ConflictState, Rules, Sight, Thoughts};
pub use draws::StandardNormals;
pub use parameters::Parameters;
pub use state::{Control, State};
pub use variant::{Variant, VariantError};
