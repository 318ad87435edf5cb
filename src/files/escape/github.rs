//! GitHub's workflow commands, `::error file=…,title=…::message`, one a line.

use std::borrow::Cow;

use super::visible::visible;

/// Text after the second `::`; its line ends are kept.
pub fn github_data(text: &str) -> String {
    let text = text.replace("\r\n", "\n");
    visible(&text, |letter| letter == '\n').replace('%', "%25").replace('\n', "%0A")
}

/// The value of a property, such as a file or a title.
pub fn github_property(text: &str) -> String {
    github_data(text).replace(':', "%3A").replace(',', "%2C")
}

/// Text for a log that GitHub may read: no line of it is a workflow command, whatever names stand at its beginning. Those of this program are
/// written past this.
pub fn without_commands(text: &str) -> Cow<'_, str> {
    let begins = |line: &str| line.trim_start().starts_with("::");
    if !text.contains("##[") && !text.lines().any(begins) {
        return Cow::Borrowed(text);
    }
    let line = |line: &str| match begins(line) {
        true => line.replacen("::", "\\u{3a}:", 1),
        false => line.to_string(),
    };
    // Of the older kind, which may stand anywhere in a line.
    Cow::Owned(text.split_inclusive('\n').map(line).collect::<String>().replace("##[", "#\\u{23}["))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::escape::hostile;

    /// As the runner reads a command: <https://github.com/actions/runner>, ActionCommand.cs.
    fn read(line: &str) -> (Vec<(String, String)>, String) {
        let rest = line.strip_prefix("::error ").expect("it is a command");
        let (properties, message) = rest.split_once("::").expect("it has a message");
        let back = |text: &str| {
            text.replace("%0A", "\n").replace("%3A", ":").replace("%2C", ",").replace("%25", "%")
        };
        let pair = |one: &str| one.split_once('=').map(|(name, value)| (name.to_string(), back(value)));
        (properties.split(',').map(|one| pair(one).expect("it is a property")).collect(), back(message))
    }

    #[test]
    fn no_name_is_a_command() {
        assert_eq!(
            without_commands("::error::x.scn\n  ::set-env\n"),
            "\\u{3a}:error::x.scn\n  \\u{3a}:set-env\n"
        );
        assert_eq!(without_commands("a ##[error]b"), "a #\\u{23}[error]b");
        for plain in ["a::b", "error: ::x", "# [x]", "", "\n"] {
            assert!(matches!(without_commands(plain), Cow::Borrowed(same) if same == plain), "{plain}");
        }
    }

    proptest! {
        #[test]
        fn the_runner_reads_what_was_said(file in hostile::text(), title in hostile::text(), said in hostile::text()) {
            let line = format!(
                "::error file={},title={}::{}", github_property(&file), github_property(&title), github_data(&said));
            prop_assert_eq!(line.lines().count(), 1);
            let (properties, message) = read(&line);
            let shown = |text: &str| visible(&text.replace("\r\n", "\n"), |letter| letter == '\n');
            prop_assert_eq!(properties, [("file".to_string(), shown(&file)), ("title".to_string(), shown(&title))]);
            prop_assert_eq!(message, shown(&said));
        }
    }
}
