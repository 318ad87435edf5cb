//! What the command line puts in the place of what files say: values, controllers, and the files that those are declared in.

use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

use super::overrides::Override;
use super::syntax::ast::{self, View};
use super::syntax::{Tree, phrase, replacement};

/// What is otherwise than the files say.
#[derive(Debug, Clone, Default)]
pub struct Outside {
    /// Values of names.
    pub set: Vec<Override>,
    /// Controllers in the place of those that scenarios name.
    pub controllers: Vec<Replacement>,
    /// Files whose definitions these controllers may name, as if `use` said so.
    pub uses: Vec<PathBuf>,
}

impl Outside {
    /// All of it in words, sorted: `av.speed=40km/h`, `controller av=my_av`, `use controllers/my_av.scn`.
    pub fn words(&self) -> Vec<String> {
        let controllers = self.controllers.iter().map(|one| format!("controller {one}"));
        // Without a controller of theirs nothing depends on these files but what is set.
        let uses = self.uses.iter().map(|path| format!("use {}", path.display()));
        let mut all: Vec<String> =
            self.set.iter().map(Override::to_string).chain(controllers).chain(uses).collect();
        all.sort();
        all
    }
}

/// A controller for every vehicle of a name, with its settings: `av=my_av { gap: 5 m }`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Replacement {
    /// In the one style.
    text: String,
}

impl Replacement {
    /// Its tree; what it is of is a [`ast::Tested`].
    pub(super) fn tree(&self) -> Option<Tree> {
        replacement(&self.text)
    }
}

impl fmt::Display for Replacement {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(&self.text)
    }
}

impl FromStr for Replacement {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let help = "write it like av=my_av or 'av=my_av { braking_distance: 8 m }'";
        let tree = replacement(text.trim())
            .ok_or_else(|| format!("`{text}` names no controller for a vehicle; {help}"))?;
        let said = ast::Tested::cast(tree.root()).filter(|said| !said.is_broken());
        let said = said.ok_or_else(|| format!("the settings in `{text}` cannot be read; {help}"))?;
        let settings = said.settings().map(|settings| format!(" {}", phrase(*settings))).unwrap_or_default();
        let (vehicle, controller) = (said.vehicle().name().text(), said.name().text());
        Ok(Self { text: format!("{vehicle}={controller}{settings}") })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_controller_and_its_settings_are_one_word_of_the_command_line() {
        let read = |text: &str| text.parse::<Replacement>().map(|one| one.to_string());
        assert_eq!(read("av=my_av").unwrap(), "av=my_av");
        assert_eq!(
            read(" av = my_av{gap:5m,profile :cautious } ").unwrap(),
            "av=my_av { gap: 5 m, profile: cautious }"
        );
        for wrong in [
            "av",
            "av=",
            "=my_av",
            "av=my_av gap: 5 m",
            "av=my_av { gap: 5 m",
            "av=a b",
            "a.b=c",
            "av=my_av # no",
            "av=a\ntest b as c",
        ] {
            assert!(read(wrong).unwrap_err().contains("names no controller"), "{wrong}");
        }
        assert!(read("av=my_av { gap 5 m }").unwrap_err().contains("cannot be read"));
    }

    #[test]
    fn what_is_otherwise_is_said_in_words() {
        let outside = Outside {
            set: vec!["tta=4s".parse().unwrap()],
            controllers: vec!["av=my_av".parse().unwrap()],
            uses: vec!["a/b.scn".into()],
        };
        assert_eq!(outside.words(), ["controller av=my_av", "tta=4s", "use a/b.scn"]);
    }
}
