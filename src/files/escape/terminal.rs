//! Text for terminals and for logs that are read in them.

use super::visible::{is_command, is_layout, visible};

/// Text of several lines: line ends and tabs stay.
pub fn terminal(text: &str) -> String {
    visible(text, is_layout)
}

/// A name within a line of others: nothing in it begins another line.
pub fn terminal_line(text: &str) -> String {
    visible(text, |_| false)
}

/// Text in which every byte has to keep its place, such as the lines of a file that marks point into. Characters of one byte
/// stay: who draws the lines makes pictures of them.
pub fn terminal_same_bytes(text: &str) -> String {
    let replaced = |letter: char| match letter.len_utf8() {
        _ if !is_command(letter) => letter,
        1 => letter,
        2 => '¿',
        3 => '\u{fffd}',
        _ => '🚫',
    };
    text.chars().map(replaced).collect()
}

/// Text that this program has coloured, after what is from outside in it was escaped: only colours are left. What could
/// hide text, move the cursor or speak to the terminal is shown.
pub fn terminal_styled(text: &str) -> String {
    let mut shown = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(start) = rest.find('\u{1b}') {
        shown += &terminal(&rest[..start]);
        let length = style_length(&rest[start..]);
        match length {
            0 => {
                shown.push_str("\\u{1b}");
                rest = &rest[start + 1..];
            }
            _ => {
                shown.push_str(&rest[start..start + length]);
                rest = &rest[start + length..];
            }
        }
    }
    shown + &terminal(rest)
}

/// How long the style is that the text begins with; 0 if it begins with anything else.
fn style_length(text: &str) -> usize {
    let Some(parameters) = text.strip_prefix("\u{1b}[") else { return 0 };
    let Some(end) = parameters.find(|letter: char| !letter.is_ascii_digit() && letter != ';') else {
        return 0;
    };
    if !parameters[end..].starts_with('m') {
        return 0;
    }
    let mut numbers = parameters[..end].split(';').map(|number| number.parse::<u8>().unwrap_or(0));
    let is_ours = match numbers.next().unwrap_or(0) {
        // One of 256 colours, as diagnostics use them.
        38 => numbers.next() == Some(5) && numbers.next().is_some() && numbers.next().is_none(),
        // Plain, bold, dim, italic, underlined, or one of the sixteen colours of letters.
        first => [first]
            .into_iter()
            .chain(numbers)
            .all(|one| matches!(one, 0..=4 | 22..=24 | 30..=37 | 39 | 90..=97)),
    };
    if is_ours { "\u{1b}[".len() + end + 1 } else { 0 }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::escape::hostile;

    #[test]
    fn colours_stay_and_nothing_else_that_is_obeyed() {
        let ours = "\u{1b}[1m\u{1b}[31mFAIL\u{1b}[0m \u{1b}[38;5;9mx\u{1b}[0m";
        assert_eq!(terminal_styled(ours), ours);
        for (hostile, shown) in [
            ("\u{1b}[8mhidden", "\\u{1b}[8mhidden"),
            ("\u{1b}[2J", "\\u{1b}[2J"),
            ("\u{1b}]8;;http://x\u{7}", "\\u{1b}]8;;http://x\\u{7}"),
            ("\u{1b}[30;40mblack", "\\u{1b}[30;40mblack"),
            ("\u{1b}[38;2;0;0;0m", "\\u{1b}[38;2;0;0;0m"),
            ("\u{1b}[", "\\u{1b}["),
            ("a\u{1b}", "a\\u{1b}"),
            ("\u{9b}2J", "\\u{9b}2J"),
        ] {
            assert_eq!(terminal_styled(hostile), shown);
        }
    }

    #[test]
    fn a_name_is_one_line() {
        assert_eq!(terminal_line("a\nPASS b\tc\r"), "a\\nPASS b\\tc\\r");
        assert_eq!(terminal("a\n\tb\r\u{202e}"), "a\n\tb\\r\\u{202e}");
    }

    proptest! {
        #[test]
        fn places_stay(text in hostile::text()) {
            let shown = terminal_same_bytes(&text);
            prop_assert!(shown.char_indices().map(|(at, _)| at).eq(text.char_indices().map(|(at, _)| at)));
            prop_assert!(!shown.contains(|letter| is_command(letter) && !letter.is_ascii()), "{shown:?}");
        }

        #[test]
        fn what_is_escaped_brings_no_colours(text in hostile::text()) {
            let shown = terminal_styled(&terminal(&text));
            prop_assert!(!shown.contains('\u{1b}'), "{shown:?}");
        }
    }
}
