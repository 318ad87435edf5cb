//! `--set NAME=VALUE` and `--repeat N`: values for this once, instead of those in the files.

use clap::Args;

use lang::Override;

#[derive(Debug, Clone, Default, Args)]
pub struct SetArguments {
    /// Gives everything of this name another value, as if it stood in the files; may be repeated. `tta=4s` is a variation, a `let`
    /// or a template's parameter, `av.speed=40km/h` a statement, `av.controller.braking_distance=5m` a parameter.
    #[arg(long, value_name = "NAME=VALUE")]
    set: Vec<Override>,

    /// Replaces `repeat` and `runs` of every scenario.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    repeat: Option<u32>,
}

impl SetArguments {
    pub fn is_empty(&self) -> bool {
        self.set.is_empty() && self.repeat.is_none()
    }

    /// Everything that is set.
    ///
    /// # Errors
    /// The name of what is set twice.
    pub fn all(&self) -> Result<Vec<Override>, String> {
        let all: Vec<Override> = self.set.iter().cloned().chain(self.repeat.map(Override::repeat)).collect();
        for (index, one) in all.iter().enumerate() {
            if all[..index].iter().any(|other| other.name == one.name) {
                return Err(one.name.clone());
            }
        }
        Ok(all)
    }
}
