//! `--set NAME=VALUE`, `--repeat N` and `--controller VEHICLE=NAME`: what is otherwise for this once than in the files.

use std::path::PathBuf;

use clap::Args;

use lang::{Override, Replacement};
use runner::project::ProjectOptions;

#[derive(Debug, Clone, Default, Args)]
pub struct SetArguments {
    /// Gives everything of this name another value, as if it stood in the files; may be repeated. `tta=4s` is a variation, a `let`
    /// or a template's parameter, `av.speed=40km/h` a statement, `av.controller.braking_distance=5m` a parameter.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<Override>,

    /// Replaces `repeat` and `runs` of every scenario.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    repeat: Option<u32>,

    /// Puts another controller in the place of that of every vehicle of this name, with its settings and whatever the scenarios say:
    /// `av=carla_behavior`, `'av=my_av { braking_distance: 8 m }'`; may be repeated. Trials keep their names.
    #[arg(long, value_name = "VEHICLE=CONTROLLER")]
    controller: Vec<Replacement>,

    /// Reads a file in which controllers for `--controller` are declared, as if `use` said so; may be repeated.
    #[arg(long = "use", value_name = "FILE")]
    uses: Vec<PathBuf>,
}

impl SetArguments {
    /// These values and controllers.
    pub fn of(set: Vec<Override>, controller: Vec<Replacement>, uses: Vec<PathBuf>) -> Self {
        Self { set, repeat: None, controller, uses }
    }

    /// What [`scenario::Suite::set`] has of such arguments; `None` if it is of something else.
    pub fn of_words(words: &[String]) -> Option<Self> {
        let mut all = Self::default();
        for word in words {
            match (word.strip_prefix("controller "), word.strip_prefix("use ")) {
                (Some(controller), _) => all.controller.push(controller.parse().ok()?),
                (_, Some(file)) => all.uses.push(file.into()),
                _ => all.set.push(word.parse().ok()?),
            }
        }
        Some(all)
    }

    pub fn is_empty(&self) -> bool {
        self.set.is_empty() && self.repeat.is_none() && self.controller.is_empty() && self.uses.is_empty()
    }

    /// All of it.
    ///
    /// # Errors
    /// The name of what is set twice.
    pub fn options(&self) -> Result<ProjectOptions, String> {
        let options = ProjectOptions::default().set(self.values()?);
        Ok(options.controllers(self.controller.clone()).uses(self.uses.clone()))
    }

    /// Every value that is set.
    fn values(&self) -> Result<Vec<Override>, String> {
        let all: Vec<Override> = self.set.iter().cloned().chain(self.repeat.map(Override::repeat)).collect();
        for (index, one) in all.iter().enumerate() {
            if all[..index].iter().any(|other| other.name == one.name) {
                return Err(one.name.clone());
            }
        }
        Ok(all)
    }
}
