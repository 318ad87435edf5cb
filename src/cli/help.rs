//! `scenario-runner help`: what a command takes, and references that belong to no command.

use clap::{Args, CommandFactory};

use super::{Cli, Exit};
use crate::lang::filter;

#[derive(Debug, Args)]
pub struct HelpArguments {
    /// A command, or `filter` for the language of filter expressions.
    #[arg(value_name = "COMMAND|filter")]
    topic: Option<String>,
}

/// The name of the reference of filter expressions, also for `explain`.
pub const FILTER: &str = "filter";

pub fn help(arguments: &HelpArguments) -> Exit {
    let mut program = Cli::command().bin_name("scenario-runner");
    program.build();
    let Some(topic) = &arguments.topic else {
        let _ = program.print_long_help();
        return Exit::Success;
    };
    if topic == FILTER {
        print!("{}", filter::reference());
        return Exit::Success;
    }
    match program.find_subcommand_mut(topic) {
        Some(command) => {
            let _ = command.print_long_help();
            Exit::Success
        }
        None => {
            let commands = program.get_subcommands().map(clap::Command::get_name).chain([FILTER]);
            eprintln!("error: there is no command `{topic}`");
            match crate::lang::nearest(topic, commands) {
                Some(near) => eprintln!("help: did you mean `scenario-runner help {near}`?"),
                None => eprintln!("help: `scenario-runner help` lists the commands"),
            }
            Exit::Usage
        }
    }
}
