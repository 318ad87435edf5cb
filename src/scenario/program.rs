//! A controller of somebody's own: a program that decides, declared beside the scenarios that it is tested in.

use std::fmt::Write;

use super::agent::CommandKind;
use super::{Dimension, Notation, Origin};
use files::escape::shell_word;

/// A program that decides for vehicles: what is started, what it gives, and in which time.
///
/// Whoever reads a declaration starts nothing; whether it may be started at all is not said here.
#[derive(Debug, Clone, PartialEq)]
pub struct DeclaredProgram {
    /// By which scenarios name it.
    pub name: String,
    /// What decides.
    pub kind: ProgramKind,
    /// Where it is started, as it is said, relative to the folder of [`Self::file`].
    pub folder: String,
    /// Names and values, in the order of the names.
    pub environment: Vec<(String, String)>,
    /// What it decides.
    pub gives: Answer,
    /// Time between two decisions, s; `None`: every simulation step.
    pub period: Option<f64>,
    /// From what it sees to what is done about it.
    pub delay: Delay,
    /// Time in free flow before the start, s.
    pub settles: f64,
    /// Wall time until it has said hello, and until it is ready for runs, s.
    pub starts_within: f64,
    /// Wall time of an answer for each run of a request, s.
    pub answers_within: f64,
    /// How many processes there may be at once; `None`: as many as there are threads.
    pub processes: Option<u32>,
    /// It is known that the same run may come out differently.
    pub is_nondeterministic: bool,
    /// The file that declares it, as it was named.
    pub file: String,
    /// Of its name.
    pub origin: Origin,
    /// Of its parameters, by name: what to point at where file and program disagree.
    pub parameters: Vec<(String, Origin)>,
}

/// What decides, and how it is reached.
#[derive(Debug, Clone, PartialEq)]
pub enum ProgramKind {
    /// A process of its own. The words of its command: the first is looked up, no shell reads any.
    Command(Vec<String>),
    /// A WebAssembly module, in a file relative to the folder of [`DeclaredProgram::file`]. It can do nothing but decide.
    Wasm(String),
    /// A functional mock-up unit for co-simulation, which a process of ours loads.
    Fmu(DeclaredFmu),
}

/// A functional mock-up unit with what its variables are for.
#[derive(Debug, Clone, PartialEq)]
pub struct DeclaredFmu {
    /// Relative to the folder of [`DeclaredProgram::file`].
    pub file: String,
    /// What it is told, by the names of [`input_signals`](super::input_signals).
    pub inputs: Vec<WiredVariable>,
    /// What it says: each of [`output_signals`](super::output_signals) once, and [`STEERS`](super::STEERS) if it steers.
    pub outputs: Vec<WiredVariable>,
    /// Its parameters that runs set, by the names by which the file declares them.
    pub parameters: Vec<WiredVariable>,
}

/// A name of ours and the variable that stands for it.
#[derive(Debug, Clone, PartialEq)]
pub struct WiredVariable {
    /// Of a signal or a parameter.
    pub name: String,
    /// Of its values.
    pub dimension: Dimension,
    /// As the unit calls it.
    pub variable: String,
    /// In which the variable is; `None`: in the one that the unit says.
    pub unit: Option<Notation>,
    /// Of the variable's name, where it is said.
    pub origin: Origin,
}

impl WiredVariable {
    /// `ego.speed = vEgo in km/h`
    fn typed(&self) -> String {
        let unit = self.unit.map_or_else(String::new, |unit| format!(" in {}", unit.symbol.as_str()));
        format!("{} = {}{unit}", self.name, shown(&self.variable))
    }
}

/// What a program answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Answer {
    /// m/s²
    Acceleration,
    /// Throttle and brake, each 0..1.
    Pedals,
    /// A speed to be reached.
    Speed,
    /// Speeds at times from now on.
    SpeedPlan,
}

/// Time between what a program sees and what is done about it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Delay {
    /// s
    Fixed(f64),
    /// The wall time that the answer took.
    Measured,
}

impl Answer {
    /// Every one.
    pub const ALL: [Self; 4] = [Self::Acceleration, Self::Pedals, Self::Speed, Self::SpeedPlan];

    /// As the language and the protocol say it.
    pub fn word(self) -> &'static str {
        match self {
            Self::Acceleration => "acceleration",
            Self::Pedals => "pedals",
            Self::Speed => "speed",
            Self::SpeedPlan => "speed_plan",
        }
    }

    /// What its vehicle is told.
    pub fn command(self) -> CommandKind {
        match self {
            Self::Pedals => CommandKind::Pedals,
            Self::Acceleration | Self::Speed | Self::SpeedPlan => CommandKind::Acceleration,
        }
    }
}

impl DeclaredProgram {
    /// Whether wall time or the program itself may make the same run come out differently.
    pub fn may_differ(&self) -> bool {
        self.is_nondeterministic || self.delay == Delay::Measured
    }

    /// Whether all that it consists of is known by its declaration, and nothing makes the same run come out differently: equal runs are
    /// equal then, whenever they are made.
    pub fn is_known_whole(&self) -> bool {
        !matches!(self.kind, ProgramKind::Command(_)) && !self.may_differ()
    }

    /// The words of its command, or what else decides, as somebody would type them.
    pub fn typed(&self) -> String {
        match &self.kind {
            ProgramKind::Command(words) => words.iter().map(|word| shown(word)).collect::<Vec<_>>().join(" "),
            ProgramKind::Wasm(file) => format!("wasm {}", shown(file)),
            ProgramKind::Fmu(fmu) => format!("fmu {}", shown(&fmu.file)),
        }
    }

    /// Whether it is a process, which may do anything that its user may.
    pub fn is_process(&self) -> bool {
        !matches!(self.kind, ProgramKind::Wasm(_))
    }

    /// What runs and how its decisions are taken: two declarations that say the same here drive alike.
    pub fn identity(&self) -> String {
        let mut text = self.typed();
        let mut say =
            |part: std::fmt::Arguments| text.write_fmt(part).expect("writing to a string cannot fail");
        if self.is_process() {
            say(format_args!(" in {}", shown(&self.folder)));
        }
        for (name, value) in &self.environment {
            say(format_args!(", {}", shown(&format!("{name}={value}"))));
        }
        if let ProgramKind::Fmu(fmu) = &self.kind {
            for (word, wires) in
                [("input", &fmu.inputs), ("output", &fmu.outputs), ("parameter", &fmu.parameters)]
            {
                wires.iter().for_each(|wire| say(format_args!(", {word} {}", wire.typed())));
            }
        }
        say(format_args!(", gives {}", self.gives.word()));
        if let Some(period) = self.period {
            say(format_args!(", every {period} s"));
        }
        match self.delay {
            Delay::Fixed(0.0) => {}
            Delay::Fixed(delay) => say(format_args!(", after {delay} s")),
            Delay::Measured => say(format_args!(", after what an answer takes")),
        }
        if self.settles > 0.0 {
            say(format_args!(", settled for {} s", self.settles));
        }
        text
    }
}

/// A word that reads as one, as a user would type it.
fn shown(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "_-./=:,+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.to_string() } else { shell_word(word) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_runs_and_how_is_its_identity() {
        let program = DeclaredProgram {
            name: "my_av".into(),
            kind: ProgramKind::Command(vec!["python3".into(), "my av.py".into()]),
            folder: "..".into(),
            environment: vec![("A".into(), "b".into())],
            gives: Answer::Acceleration,
            period: Some(0.1),
            delay: Delay::Fixed(0.05),
            settles: 0.0,
            starts_within: 30.0,
            answers_within: 10.0,
            processes: None,
            is_nondeterministic: false,
            file: "a.scn".into(),
            origin: Origin::default(),
            parameters: Vec::new(),
        };
        assert_eq!(
            program.identity(),
            "python3 'my av.py' in .., A=b, gives acceleration, every 0.1 s, after 0.05 s"
        );
        let limits = DeclaredProgram { answers_within: 1.0, file: "b.scn".into(), ..program.clone() };
        assert_eq!(limits.identity(), program.identity());
        let module = DeclaredProgram { kind: ProgramKind::Wasm("brakes.wasm".into()), ..program.clone() };
        assert!(module.identity().starts_with("wasm brakes.wasm, A=b, gives"), "{}", module.identity());
        let unit = |unit: &'static str| Notation {
            symbol: super::super::Symbol::new(unit),
            numerator: 1.0,
            denominator: 1.0,
        };
        let fmu = |said: &'static str| {
            let wire = WiredVariable {
                name: "ego.speed".into(),
                dimension: Dimension::SPEED,
                variable: "vEgo".into(),
                unit: Some(unit(said)),
                origin: Origin::default(),
            };
            let (inputs, outputs, parameters) = (vec![wire], Vec::new(), Vec::new());
            let kind = ProgramKind::Fmu(DeclaredFmu { file: "aeb.fmu".into(), inputs, outputs, parameters });
            DeclaredProgram { kind, ..program.clone() }.identity()
        };
        assert!(fmu("m/s").starts_with("fmu aeb.fmu in .., A=b, input ego.speed = vEgo in m/s, gives"));
        assert_ne!(fmu("m/s"), fmu("km/h"));
    }
}
