//! What the process of a unit has to know, as its command line names it in a file.

use ::fmu::{Description, LibraryPlace, Unpacked};
use serde::{Deserialize, Serialize};
use serde_json::{Value as Json, json};

use super::wired::Wired;
use super::wiring::FmuWiring;
use crate::hello::PROTOCOL;
use scenario::{DeclaredProgram, STEERS};

/// Runs that a process takes at once; each has an instance of its own.
const AT_ONCE: usize = 16;

/// What a process does with a unit.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FmuPlan {
    pub place: LibraryPlace,
    /// Whether a library takes one instance, and the next needs it loaded anew.
    pub is_once_per_process: bool,
    /// Time between two decisions, s; `None`: every step of a simulation.
    pub period: Option<f64>,
    /// By the place of the signal in [`scenario::input_signals`].
    pub inputs: Vec<(usize, Wired)>,
    /// In the order of the answer, the curvature last if there is one.
    pub outputs: Vec<Wired>,
    pub parameters: Vec<Wired>,
    /// What it says of itself.
    pub hello: Json,
}

impl FmuPlan {
    /// Whether the unit steers.
    pub fn steers(&self) -> bool {
        self.outputs.last().is_some_and(|last| last.name == STEERS.name)
    }
}

/// The plan for a unit.
pub fn plan(
    program: &DeclaredProgram,
    description: &Description,
    unpacked: Unpacked,
    wiring: FmuWiring,
) -> FmuPlan {
    let Unpacked { library, resources } = unpacked;
    let FmuWiring { inputs, outputs, parameters, said } = wiring;
    let (version, token) = (description.version, description.token.clone());
    let is_once_per_process = description.is_once_per_process;
    let hello = json!({"hello": {
        "protocol": PROTOCOL,
        "name": description.name,
        "version": description.model_version,
        "encoding": "f64",
        "tables": ["lanes", "kinds"],
        "runs_at_once": if is_once_per_process { 1 } else { AT_ONCE },
        "gives": [program.gives.word()],
        "parameters": said,
    }});
    FmuPlan {
        place: LibraryPlace { version, library, resources, token },
        is_once_per_process,
        period: program.period,
        inputs,
        outputs,
        parameters,
        hello,
    }
}
