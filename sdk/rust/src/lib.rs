//! Controllers of automated vehicles in Rust, tested by scenario-runner.
//!
//! A program implements [`Controller`], says in [`About`] what the runner is told of it, and calls [`serve`]; a WebAssembly module says
//! [`module!`] instead. Everything is in SI units: x
//! ahead of the vehicle's centre, y to the left of the middle of its lane, velocities over ground. What is not there is NaN.
//! There is a value of the controller for each run. An error is an error of that run; a panic ends the process, whereupon the
//! runner makes each of the runs under way again alone.
//!
//! On Unix, standard output is taken away in `serve`: what is printed from then on goes to the log.

#![deny(missing_docs)]

use std::collections::BTreeMap;
use std::io::{self, BufRead, BufReader, Read, Write};

use serde::{Deserialize, Serialize};
use serde_json::{json, Value};

mod conversation;
mod module;
mod wire;

use conversation::{Conversation, Reply};
#[doc(hidden)]
pub use module::Module;

/// The protocol that is spoken.
pub const PROTOCOL: u64 = 1;

/// The most points of a speed plan.
pub const PLAN_POINTS: usize = 16;

/// A controller of one run.
pub trait Controller: Sized {
    /// A run begins.
    ///
    /// # Errors
    /// Why it cannot.
    fn start(run: &Run) -> Result<Self, String>;

    /// What the vehicle is to do, having seen this.
    ///
    /// # Errors
    /// Why it cannot decide: an error of the run.
    fn step(&mut self, seen: &Seen) -> Result<Answer, String>;

    /// The run is over: `completed`, `collision`, `horizon` or `abandoned`.
    fn finish(&mut self, _reason: &str) {}
}

/// What the runner is told of a controller.
#[derive(Debug, Clone, PartialEq)]
pub struct About {
    /// As reports call it.
    pub name: String,
    /// Of the program.
    pub version: String,
    /// Which variant of [`Command`] it answers with.
    pub gives: Gives,
    /// How many runs it may be asked for in one request, 1 .. 1024.
    pub runs_at_once: usize,
    /// Words for what it is up to.
    pub modes: Vec<String>,
    /// What a scenario may set.
    pub parameters: Vec<Parameter>,
}

/// What a controller answers with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Gives {
    /// [`Command::Acceleration`]
    Acceleration,
    /// [`Command::Pedals`]
    Pedals,
    /// [`Command::Speed`]
    Speed,
    /// [`Command::SpeedPlan`]
    SpeedPlan,
}

/// A parameter that a scenario may set.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Parameter {
    name: String,
    default: Value,
    #[serde(skip_serializing_if = "Option::is_none")]
    unit: Option<String>,
    #[serde(skip_serializing_if = "Option::is_none")]
    low: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    high: Option<Value>,
    #[serde(skip_serializing_if = "Option::is_none")]
    options: Option<Vec<String>>,
}

impl Parameter {
    fn plain(name: &str, default: Value) -> Self {
        Self { name: name.into(), default, unit: None, low: None, high: None, options: None }
    }

    /// A number in an SI unit (`m`, `s`, `m/s`, `m/s^2`, `rad` or nothing) within a range.
    pub fn number(name: &str, unit: &str, default: f64, (low, high): (f64, f64)) -> Self {
        let plain = Self::plain(name, json!(default));
        Self { unit: Some(unit.into()), low: Some(json!(low)), high: Some(json!(high)), ..plain }
    }

    /// A whole number within a range.
    pub fn whole(name: &str, default: i64, (low, high): (i64, i64)) -> Self {
        Self { low: Some(json!(low)), high: Some(json!(high)), ..Self::plain(name, json!(default)) }
    }

    /// True or false.
    pub fn flag(name: &str, default: bool) -> Self {
        Self::plain(name, json!(default))
    }

    /// One of some words.
    pub fn word(name: &str, default: &str, options: &[&str]) -> Self {
        let options = Some(options.iter().map(ToString::to_string).collect());
        Self { options, ..Self::plain(name, json!(default)) }
    }

    /// Any text.
    pub fn text(name: &str, default: &str) -> Self {
        Self::plain(name, json!(default))
    }
}

/// A run that begins.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct Run {
    /// By which it is spoken of.
    pub slot: usize,
    /// For whoever draws numbers; it tells nothing of which run it is.
    pub seed: u64,
    /// Of the simulation, s.
    pub step: f64,
    /// What every parameter is set to.
    pub parameters: BTreeMap<String, Value>,
    /// m/s
    pub cruise_speed: f64,
    /// The vehicle that is driven.
    pub vehicle: Size,
    /// Where that is.
    pub road: Road,
}

impl Run {
    /// A number among the parameters.
    ///
    /// # Errors
    /// If there is none of this name.
    pub fn number(&self, name: &str) -> Result<f64, String> {
        self.parameter(name)?.as_f64().ok_or_else(|| format!("`{name}` is no number"))
    }

    /// A flag among the parameters.
    ///
    /// # Errors
    /// If there is none of this name.
    pub fn flag(&self, name: &str) -> Result<bool, String> {
        self.parameter(name)?.as_bool().ok_or_else(|| format!("`{name}` is no flag"))
    }

    /// A word or text among the parameters.
    ///
    /// # Errors
    /// If there is none of this name.
    pub fn text(&self, name: &str) -> Result<&str, String> {
        self.parameter(name)?.as_str().ok_or_else(|| format!("`{name}` is no text"))
    }

    fn parameter(&self, name: &str) -> Result<&Value, String> {
        self.parameters.get(name).ok_or_else(|| format!("there is no parameter `{name}`"))
    }
}

/// Length and width, m.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[allow(missing_docs)]
pub struct Size {
    pub length: f64,
    pub width: f64,
}

/// The street: x along the vehicle's lane from the middle of the crossing, y to the left of the lane's middle.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[allow(missing_docs)]
pub struct Road {
    pub lane_width: f64,
    pub speed_limit: f64,
    pub lanes: Vec<Lane>,
    pub crossing: Crossing,
    pub kerbs: Kerbs,
    /// What hides and blocks, such as parked cars.
    pub boxes: Vec<Obstacle>,
}

/// A lane: y of its middle, and 1 if it is driven in the vehicle's direction, else -1.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[allow(missing_docs)]
pub struct Lane {
    pub y: f64,
    pub direction: i32,
}

/// `zebra`, `unmarked` or `signalised`, and how wide it is.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[allow(missing_docs)]
pub struct Crossing {
    pub kind: String,
    pub width: f64,
}

/// y of the kerbs.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[allow(missing_docs)]
pub struct Kerbs {
    pub right: f64,
    pub left: f64,
}

/// Something that hides and blocks.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[allow(missing_docs)]
pub struct Obstacle {
    pub x: f64,
    pub y: f64,
    pub length: f64,
    pub width: f64,
}

/// The scene of one decision.
#[derive(Debug, Clone, PartialEq)]
#[allow(missing_docs)]
pub struct Seen {
    pub slot: usize,
    /// s; negative while the vehicle drives freely before the run begins.
    pub time: f64,
    /// Whether this is the run's first decision.
    pub is_new: bool,
    pub cruise_speed: f64,
    /// From the vehicle's centre to the middle of the crossing; negative behind it.
    pub distance_to_crossing: f64,
    pub speed: f64,
    pub acceleration: f64,
    pub length: f64,
    pub width: f64,
    pub lane_width: f64,
    pub speed_limit: f64,
    pub crossing_width: f64,
    pub pedestrian_priority: bool,
    /// At a signal: whether vehicles have green, neither red nor amber.
    pub signal: Option<bool>,
    pub right_kerb: f64,
    pub left_kerb: f64,
    /// Along the lane, 0 at the middle of the crossing.
    pub travelled: f64,
    /// Of the lane at the vehicle, to the left, 1/m.
    pub curvature: f64,
    /// Rise of the road per metre ahead; NaN where it says none.
    pub gradient: f64,
    /// Whether vehicles have amber.
    pub amber: bool,
    /// From the near edge of the crossing back to the line at which vehicles stop; NaN without a signal.
    pub stop_line: f64,
    /// From the middle of its lane to the vehicle, to the left.
    pub lateral_offset: f64,
    /// From the direction of its lane to that of the vehicle, to the left, rad.
    pub heading_error: f64,
    /// How the lane bends within 150 m: distances ahead and the curvature there, ascending. From `curvature` on it changes evenly from
    /// each to the next, and not at all behind the last; two at one distance are a jump.
    pub curvature_ahead: Vec<(f64, f64)>,
    /// Every crossing of the road, in the order in which the vehicle comes to them; the fields above are of the first of them that it has
    /// not left behind. Empty where the runner is older than this.
    pub crossings: Vec<SeenCrossing>,
    pub pedestrians: Vec<Other>,
    /// Without accelerations.
    pub vehicles: Vec<Other>,
}

/// A pedestrian or another vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct Other {
    pub id: u64,
    pub x: f64,
    pub y: f64,
    pub vx: f64,
    pub vy: f64,
    pub ax: f64,
    pub ay: f64,
    pub length: f64,
    pub width: f64,
    /// Who rides is among the pedestrians.
    pub kind: Kind,
}

/// What somebody is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Kind {
    Pedestrian,
    Cyclist,
    Escooter,
    Vehicle,
}

/// A crossing, seen from the vehicle.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs)]
pub struct SeenCrossing {
    /// From the vehicle's centre to its middle; negative behind it.
    pub distance: f64,
    pub width: f64,
    pub pedestrian_priority: bool,
    /// y of where people may wait, beyond a kerb or on a refuge.
    pub right_edge: f64,
    pub left_edge: f64,
}

/// What a vehicle is to do.
#[derive(Debug, Clone, PartialEq)]
pub enum Command {
    /// m/s²
    Acceleration(f64),
    /// 0 .. 1
    #[allow(missing_docs)]
    Pedals { throttle: f64, brake: f64 },
    /// m/s
    Speed(f64),
    /// Seconds from when it takes effect, ascending, and speeds, m/s; at most [`PLAN_POINTS`].
    SpeedPlan(Vec<(f64, f64)>),
}

/// What was decided.
#[derive(Debug, Clone, PartialEq)]
pub struct Answer {
    /// What the vehicle is to do.
    pub command: Command,
    /// What the controller is up to, as an index of [`About::modes`].
    pub mode: Option<usize>,
    /// The curvature of the way that the rear axle is to take, to the left, 1/m. Without it the vehicle keeps its lane, or once it was
    /// steered goes on beside it.
    pub curvature: Option<f64>,
}

impl From<Command> for Answer {
    fn from(command: Command) -> Self {
        Self { command, mode: None, curvature: None }
    }
}

/// Speaks with the runner until it says goodbye. `--runs-at-once=1` on the command line goes before what is said in `about`.
///
/// # Errors
/// If the runner cannot be reached, or says what is not in the protocol.
pub fn serve<C: Controller>(about: &About) -> io::Result<()> {
    let (requests, answers) = streams()?;
    let wanted = std::env::args().find_map(|one| one.strip_prefix("--runs-at-once=")?.parse().ok());
    let about = About { runs_at_once: wanted.unwrap_or(about.runs_at_once), ..about.clone() };
    converse::<C>(&about, BufReader::with_capacity(1 << 16, requests), answers)
}

/// Answers the requests of one stream on another.
///
/// # Errors
/// If they cannot be read or written, or are not of the protocol.
pub fn converse<C: Controller>(
    about: &About,
    mut requests: impl BufRead,
    mut answers: impl Write,
) -> io::Result<()> {
    let mut line = String::new();
    if requests.read_line(&mut line)? == 0 {
        return Ok(());
    }
    let (mut conversation, hello) = Conversation::<C>::begin(about, &serde_json::from_str(&line)?);
    writeln!(answers, "{hello}")?;
    answers.flush()?;
    let mut frame = Vec::new();
    while wire::read(&mut requests, &mut frame)? {
        match conversation.reply(&frame)? {
            Reply::Answer => answers.write_all(&conversation.answer).and_then(|()| answers.flush())?,
            Reply::None => {}
            Reply::Bye => return Ok(()),
        }
    }
    Ok(())
}

/// Standard input and output; from then on, what is printed goes to standard error.
#[cfg(unix)]
fn streams() -> io::Result<(impl Read, impl Write)> {
    use std::fs::File;
    use std::os::fd::AsFd;
    extern "C" {
        fn dup2(from: i32, to: i32) -> i32;
    }
    let requests = File::from(io::stdin().as_fd().try_clone_to_owned()?);
    let answers = File::from(io::stdout().as_fd().try_clone_to_owned()?);
    // SAFETY: it is given numbers of descriptors and touches no memory.
    if unsafe { dup2(2, 1) } < 0 {
        return Err(io::Error::last_os_error());
    }
    Ok((requests, answers))
}

#[cfg(not(unix))]
fn streams() -> io::Result<(impl Read, impl Write)> {
    Ok((io::stdin(), io::stdout()))
}
