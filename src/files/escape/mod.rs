//! What comes from outside (names, doc strings, file names, messages of models, words of people's files) as it may stand in
//! each target: one file a target, and nothing else escapes.
//!
//! All of them show characters that command a reader's program instead of being read (control characters, directional
//! overrides, invisible tags, characters that are none) as `\u{1b}`, and add what their own syntax needs. Escaping is
//! repeatable: what was escaped for one target can be escaped for another, and shows the same.

mod csv;
mod github;
mod html;
mod markdown;
mod shell;
mod tap;
mod terminal;
mod visible;
mod xml;

pub use self::csv::csv_cell;
pub use self::github::{github_data, github_property, without_commands};
pub use self::html::{html, html_characters};
pub use self::markdown::{markdown, markdown_code, markdown_fenced};
pub use self::shell::{shell_path, shell_word};
pub use self::tap::{tap_description, tap_text, yaml_quoted};
pub use self::terminal::{terminal, terminal_line, terminal_same_bytes, terminal_styled};
pub use self::visible::{is_command, json_text};
pub use self::xml::{xml, xml_line};

#[cfg(test)]
pub(crate) mod hostile;

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::visible::{is_command, is_layout};
    use super::*;

    #[test]
    fn names_of_people_and_places_stay_as_they_are() {
        for text in
            ["zebra/Frédéric/tta=6s", "東京 横断歩道", "σ = 0.5, ½ m, 20 °C", "👩\u{200d}🦽 e\u{301}", "–✓✗"]
        {
            for escaped in [
                terminal(text),
                terminal_line(text),
                xml(text),
                html(text),
                github_data(text),
                tap_text(text),
            ] {
                assert_eq!(escaped, text);
            }
        }
    }

    proptest! {
        #[test]
        fn nothing_that_is_obeyed_gets_through(text in hostile::text()) {
            let layout = |letter: char| is_command(letter) && !is_layout(letter);
            for escaped in [terminal(&text), terminal_styled(&text).replace('\u{1b}', ""), xml(&text), html(&text), tap_text(&text)] {
                prop_assert!(!escaped.contains(layout), "{escaped:?}");
            }
            for line in [
                terminal_line(&text), github_data(&text), github_property(&text), markdown(&text),
                markdown_code(&text), xml_line(&text), tap_description(&text), yaml_quoted(&text), csv_cell(&text),
            ] {
                prop_assert!(!line.contains(is_command), "{line:?}");
            }
        }

        #[test]
        fn escaping_what_is_escaped_changes_nothing(text in hostile::text()) {
            for escape in [terminal as fn(&str) -> String, terminal_line, terminal_same_bytes, xml, xml_line, html_characters] {
                let once = escape(&text);
                prop_assert_eq!(escape(&once), once);
            }
        }
    }
}
