//! What keys ask for.

/// What somebody asks for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Key {
    All,
    Failed,
    /// A filter is being typed.
    Typing,
    /// A filter expression, or nothing.
    Filter(String),
    /// None was typed to its end: it stays as it was.
    Kept,
    Report,
    Watched,
    Help,
    Quit,
}

impl Key {
    /// What a key stands for. One that stands for nothing shows what there is.
    pub fn of(key: char) -> Option<Self> {
        Some(match key {
            '\n' | '\r' | 'a' => Self::All,
            'f' => Self::Failed,
            '/' | 'p' => Self::Typing,
            'o' => Self::Report,
            'w' => Self::Watched,
            'q' => Self::Quit,
            _ if key == 'h' || key == '?' || key.is_ascii_alphanumeric() => Self::Help,
            // Such as the rest of an arrow.
            _ => return None,
        })
    }
}

/// What `h` shows.
pub const HELP: &str = "\
  Enter, a   run everything again
  f          run again what did not pass
  / or p     a filter expression (`scenario-runner help filter`); an empty one selects everything
  o          write an HTML report of the last run, and open it
  w          list what is watched
  q          quit
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_of_the_help_stands_for_something_else() {
        let keys: Vec<Option<Key>> = "\nf/owhq".chars().map(Key::of).collect();
        assert!(keys.iter().all(Option::is_some));
        assert!((0..keys.len()).all(|index| !keys[..index].contains(&keys[index])));
        assert_eq!((Key::of('a'), Key::of('p'), Key::of('?')), (Key::of('\n'), Key::of('/'), Key::of('h')));
        assert_eq!((Key::of('\u{1b}'), Key::of('[')), (None, None));
        assert_eq!(Key::of('x'), Some(Key::Help), "one that is unknown shows what there is");
    }
}
