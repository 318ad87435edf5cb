//! TAP 14: descriptions of test points, and the YAML of their blocks.

use super::visible::{is_layout, push_visible, visible};

/// The description of a test point or the reason of a directive: one line, in which `#` begins nothing.
pub fn tap_description(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '\\' | '#' => plain.extend(['\\', letter]),
            '\n' | '\r' => plain.push(' '),
            _ => push_visible(&mut plain, letter, &|_| false),
        }
    }
    plain
}

/// Lines for a literal block of YAML: all of them of characters that YAML prints.
pub fn tap_text(text: &str) -> String {
    visible(text, is_layout)
}

/// A double-quoted YAML scalar: YAML takes every JSON string of printable characters.
pub fn yaml_quoted(text: &str) -> String {
    serde_json::Value::from(tap_text(text)).to_string()
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::escape::hostile;

    proptest! {
        #[test]
        fn a_description_is_read_back(text in hostile::text()) {
            let line = tap_description(&text);
            prop_assert!(line.lines().count() <= 1);
            // A reader takes the first `#` that is not escaped for a directive.
            let mut letters = line.chars();
            let mut said = String::new();
            while let Some(letter) = letters.next() {
                match letter {
                    '\\' => said.extend(letters.next()),
                    '#' => prop_assert!(false, "{line:?}"),
                    _ => said.push(letter),
                }
            }
            // Commands are shown by a backslash too, which its reader takes away.
            if !text.contains(crate::escape::visible::is_command) {
                prop_assert_eq!(said, text);
            }
        }

        #[test]
        fn yaml_reads_what_was_said(text in hostile::text()) {
            let shown = tap_text(&text);
            let quoted: serde_yaml::Value = serde_yaml::from_str(&format!("said: {}", yaml_quoted(&text))).unwrap();
            prop_assert_eq!(quoted["said"].as_str(), Some(shown.as_str()));
            let lines: String = shown.lines().map(|line| format!("    {line}\n")).collect();
            let block: serde_yaml::Value = serde_yaml::from_str(&format!("  said: |2-\n{lines}  after: 1\n")).unwrap();
            prop_assert_eq!(block["after"].as_i64(), Some(1));
        }
    }
}
