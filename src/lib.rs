//! Testing automated-vehicle controllers against pedestrians who behave like people.
//!
//! A [`Project`] is what files say, a [`Session`] runs it, [`Results`] are what came of it, and every function of [`report`] makes
//! something of them to be read. What files may name is a [`Registry`](registry::Registry): [`models::standard`] has all that ships,
//! and a controller, pedestrian or metric of one's own is added to it (`examples/own_controller.rs` and its like).
//!
//! ```
//! use scenario_runner::results::{Overall, Unheard};
//! use scenario_runner::{Memory, Project, Selection, Session, models, report};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let text = r#"
//! scenario steps_out {
//!   road { lanes forward; lane_width 3.5 m; speed_limit 50 km/h; crossing zebra { width: 4 m } }
//!   vehicle av { controller carla_behavior; speed 40 km/h; start 60 m before crossing }
//!   pedestrian walker { model scripted; start 2 m from kerb; appears at 1 s }
//!   expect { no collision }
//! }
//! "#;
//! // Texts come from memory here; `Disk` has files.
//! let files = Memory::default().with("steps_out.scn", text);
//! let project = Project::open("steps_out.scn", &models::standard(), &files)?;
//! let results = Session::new(&project).run(&Selection::all(), &mut Unheard)?;
//! assert_eq!(results.overall(), Overall::Passed);
//!
//! let mut tap = Vec::new();
//! report::write_tap(&results, &mut tap)?;
//! assert!(String::from_utf8(tap)?.contains("ok 1 - steps_out/steps_out"));
//! # Ok(())
//! # }
//! ```
//!
//! A file that is wrong gives [`project::Problems`] with the place of each; a run that cannot be made is an *error* of its trial and
//! never passed; what was not run has not passed either. A run is a pure function of its case: whichever
//! [`Executor`](run::Executor) makes it, on however many threads, every bit is the same.

// What `clippy.toml` bans is banned from what is shipped; tests may use it.
#![cfg_attr(not(test), warn(clippy::disallowed_methods))]
// Their failing is a panic: a closed pipe would end the program with the code of a bug.
#![deny(clippy::print_stdout, clippy::print_stderr, clippy::dbg_macro)]

pub mod cli;
pub mod testing;

pub use files::{Disk, Files, Memory};
pub use models;
pub use report;
pub use results;
pub use results::Results;
pub use runner::project::{Project, ProjectOptions};
pub use runner::session::{Selection, Session};
pub use scenario;
pub use scenario::registry;
pub use sim;
