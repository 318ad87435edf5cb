//! `scenario-runner help`: what a command takes, and references that belong to no command.

use clap::{Args, Command};

use super::Exit;
use lang::filter;
use report::console::{stderr, stdout};

#[derive(Debug, Args)]
pub struct HelpArguments {
    /// A command, or `filter` for the language of filter expressions.
    #[arg(value_name = "COMMAND|filter")]
    topic: Option<String>,
}

/// The name of the reference of filter expressions, also for `explain`.
pub const FILTER: &str = "filter";

/// Shows the help of `program` or of one of its commands.
pub fn help(arguments: &HelpArguments, program: Command) -> Exit {
    let mut program = program.bin_name("scenario-runner");
    program.build();
    let Some(topic) = &arguments.topic else {
        stdout().styled(&styled_help(&mut program));
        return Exit::Success;
    };
    if topic == FILTER {
        write!(stdout(), "{}", filter::reference());
        return Exit::Success;
    }
    match program.find_subcommand_mut(topic) {
        Some(command) => {
            stdout().styled(&styled_help(command));
            Exit::Success
        }
        None => {
            let commands = program.get_subcommands().map(Command::get_name).chain([FILTER]);
            writeln!(stderr(), "error: there is no command `{topic}`");
            match lang::nearest(topic, commands) {
                Some(near) => writeln!(stderr(), "help: did you mean `scenario-runner help {near}`?"),
                None => writeln!(stderr(), "help: `scenario-runner help` lists the commands"),
            }
            Exit::Usage
        }
    }
}

fn styled_help(command: &mut Command) -> String {
    let help = command.render_long_help();
    if stdout().takes_colour() { help.ansi().to_string() } else { help.to_string() }
}
