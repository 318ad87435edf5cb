//! Controllers of one's own.

use super::{Doc, Expression, Integer, List, Name, Text};
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
    }
    /// `command "python3", "-m", "my_av"`
    Command = command { words: [Text] }
    /// `wasm "FILE"`
    Wasm = wasm { path: Text }
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
    /// `parameter NAME = DEFAULT in LOW .. HIGH "what it is"`
    OwnParameter = own_parameter { name: Name, default: Expression, values: (OwnValues), doc: (Text) }
    /// `in LOW .. HIGH`, `in whole LOW .. HIGH` or `in [A, B]`
    OwnValues = own_values { list: (List), is_whole: {kw_whole}, bounds: [Expression] }
}
