//! Controllers of one's own.

use super::super::entry::{BlockEntry, BlockKind, YamlShape, statement};
use super::DOC;
use super::{Doc, Expression, Integer, List, Name, Signal, Text, Unit};
#[cfg(test)]
use super::{Holds, Made};
use super::{Node, Rule, View};

views! {
    /// `controller NAME { … }`
    ControllerDefinition = controller_definition { name: Name, block: ControllerBlock }
    ControllerBlock = controller_block {
        doc: (Doc),
        command: (Command),
        wasm: (Wasm),
        fmu: (Fmu),
        folder: (Folder),
        environment: (Environment),
        gives: (Gives),
        dynamics: (Driven),
        period: (Period),
        delay: (Delay),
        settles: (Settles),
        starts_within: (StartsWithin),
        answers_within: (AnswersWithin),
        processes: (Processes),
        nondeterministic: (Nondeterministic),
        parameters: [OwnParameter],
        inputs: [Input],
        outputs: [Output],
    }
    /// `command "python3", "-m", "my_av"`
    Command = command { words: [Text] }
    /// `wasm "FILE"`
    Wasm = wasm { path: Text }
    /// `fmu "FILE"`
    Fmu = fmu { path: Text }
    Folder = folder { path: Text }
    /// `environment "NAME=VALUE", …`
    Environment = environment { pairs: [Text] }
    Gives = gives { is_pedals: {kw_pedals}, is_speed: {kw_speed}, is_speed_plan: {kw_speed_plan} }
    /// `dynamics NAME`
    Driven = driven { name: Name }
    Period = period { value: Expression }
    /// `delay 50 ms` or `delay measured`
    Delay = delay { is_measured: {kw_measured}, value: (Expression) }
    Settles = settles { value: Expression }
    StartsWithin = starts_within { value: Expression }
    AnswersWithin = answers_within { value: Expression }
    Processes = processes { number: Integer }
    Nondeterministic = nondeterministic {}
    /// `parameter NAME = DEFAULT in LOW .. HIGH as "VARIABLE" in UNIT "what it is"`
    OwnParameter = own_parameter { name: Name, default: Expression, values: (OwnValues), wired: (Wired), doc: (Text) }
    /// `in LOW .. HIGH`, `in whole LOW .. HIGH` or `in [A, B]`
    OwnValues = own_values { list: (List), is_whole: {kw_whole}, bounds: [Expression] }
    /// `as "VARIABLE" in UNIT`
    Wired = wired { variable: Text, unit: (InUnit) }
    /// `input SIGNAL = "VARIABLE" in UNIT`
    Input = input { signal: Signal, variable: Text, unit: (InUnit) }
    /// `output SIGNAL = "VARIABLE" in UNIT`
    Output = output { signal: Signal, variable: Text, unit: (InUnit) }
    InUnit = in_unit { unit: Unit }
}

pub static CONTROLLER: BlockEntry = BlockEntry {
    kind: BlockKind::Controller,
    rule: Rule::controller_block,
    name: "a `controller`",
    heads: &[DOC],
    statements: &[
        statement(
            "command",
            Rule::command,
            "command \"python3\", \"-m\", \"my_av\"",
            "The program that decides, word by word; no shell reads them.",
        )
        .key("command", YamlShape::Texts),
        statement(
            "wasm",
            Rule::wasm,
            "wasm \"brakes.wasm\"",
            "The WebAssembly module that decides, in place of a `command`: it is given nothing but what its vehicle sees, and needs no permission.",
        )
        .key("wasm", YamlShape::Text),
        statement(
            "fmu",
            Rule::fmu,
            "fmu \"aeb.fmu\"",
            "The functional mock-up unit that decides, in place of a `command`: for co-simulation, of FMI 2.0 or 3.0.",
        )
        .key("fmu", YamlShape::Text),
        statement(
            "folder",
            Rule::folder,
            "folder \"..\"",
            "Where the program is started; the folder of this file if not said.",
        )
        .key("folder", YamlShape::Text),
        statement(
            "environment",
            Rule::environment,
            "environment \"MY_AV_MODEL=v3.onnx\", \"OMP_NUM_THREADS=1\"",
            "What the program finds in its environment besides what is always there.",
        )
        .key("environment", YamlShape::Texts),
        statement(
            "gives",
            Rule::gives,
            "gives acceleration",
            "What it decides: `acceleration`, `pedals`, `speed` or `speed_plan`; `acceleration` if not said.",
        )
        .key("gives", YamlShape::Words),
        statement("dynamics", Rule::driven, "dynamics delay_lag", "The dynamics of vehicles that say none.")
            .key("dynamics", YamlShape::Words),
        statement(
            "period",
            Rule::period,
            "period 100 ms",
            "Time between two decisions; every simulation step if not said.",
        )
        .key("period", YamlShape::Words),
        statement(
            "delay",
            Rule::delay,
            "delay 50 ms` or `delay measured",
            "From what is seen to what is done about it; none if not said, and with `measured` what the answer took.",
        )
        .key("delay", YamlShape::Words),
        statement(
            "settles within",
            Rule::settles,
            "settles within 2 s",
            "Free driving before the start; none if not said.",
        )
        .key("settles", YamlShape::Words),
        statement(
            "starts within",
            Rule::starts_within,
            "starts within 30 s",
            "Wall time in which the program must say hello, and get ready for runs; 30 s if not said.",
        )
        .key("starts", YamlShape::Words),
        statement(
            "answers within",
            Rule::answers_within,
            "answers within 1 s",
            "Wall time in which it must answer, for each run of a request; 10 s if not said.",
        )
        .key("answers", YamlShape::Words),
        statement(
            "at most",
            Rule::processes,
            "at most 2 processes",
            "How many processes of it may run at once; as many as there are threads if not said.",
        )
        .key("at_most", YamlShape::Words),
        statement(
            "nondeterministic",
            Rule::nondeterministic,
            "nondeterministic",
            "It is known that the same run may come out differently.",
        )
        .key("nondeterministic", YamlShape::Flag),
        statement(
            "parameter",
            Rule::own_parameter,
            "parameter gap = 5 m in 1 m .. 30 m \"Gap to whoever crosses.\"`, `parameter profile = normal in [cautious, normal]` or `parameter horizon = 20 in whole 5 .. 80` or `parameter time_gap = 1.5 s in 0.5 s .. 3 s as \"T_gap\" in s \"Gap.\"",
            "A parameter with its default, its range or options, what it is called in an `fmu`, and what it is.",
        )
        .key("parameters", YamlShape::OwnParameters)
        .repeats(),
        statement(
            "input",
            Rule::input,
            "input ego.speed = \"vEgo\" in km/h",
            "The variable of an `fmu` that is told something of what the vehicle sees, and in which unit if the unit says none.",
        )
        .key("inputs", YamlShape::Lines)
        .repeats(),
        statement(
            "output",
            Rule::output,
            "output acceleration = \"axReq\" in m/s^2",
            "The variable of an `fmu` that says what the vehicle is to do, and in which unit if the unit says none.",
        )
        .key("outputs", YamlShape::Lines)
        .repeats(),
    ],
};
