//! Text in GitHub's Markdown.

use super::visible::{is_layout, push_visible, visible};

/// Text in a line in which nothing means more than it says.
pub fn markdown(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '&' => plain.push_str("&amp;"),
            '\n' | '\r' => plain.push(' '),
            // Nobody is called, and nothing becomes a link, an image, a formula or a reference.
            '\\' | '`' | '*' | '_' | '|' | '~' | '[' | ']' | '#' | '!' | '$' => plain.extend(['\\', letter]),
            '@' => plain.push_str("&#64;"),
            _ => push_visible(&mut plain, letter, &|_| false),
        }
    }
    plain
}

/// Text as code within a line, with its backticks.
pub fn markdown_code(text: &str) -> String {
    let text = visible(text, |_| false);
    let fence = "`".repeat(longest_run(&text, '`') + 1);
    let space = if text.starts_with('`') || text.ends_with('`') || text.is_empty() { " " } else { "" };
    format!("{fence}{space}{text}{space}{fence}")
}

/// Lines as they are, in a fence that nothing in them ends.
pub fn markdown_fenced(text: &str) -> String {
    let text = visible(text, is_layout);
    let fence = "~".repeat((longest_run(&text, '~') + 1).max(4));
    format!("{fence}text\n{}\n{fence}\n", text.trim_end_matches('\n'))
}

fn longest_run(text: &str, letter: char) -> usize {
    text.split(|other| other != letter).map(str::len).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;
    use pulldown_cmark::{Event, Options, Parser, Tag, TagEnd, TextMergeStream};

    use super::*;
    use crate::escape::hostile;

    /// What a reader of Markdown sees in a paragraph or a cell: plain text, or an event that is more than that.
    fn plain(source: &str) -> Result<String, String> {
        let mut said = String::new();
        let github = Options::ENABLE_GFM | Options::ENABLE_TABLES | Options::ENABLE_FOOTNOTES;
        let github =
            github | Options::ENABLE_STRIKETHROUGH | Options::ENABLE_TASKLISTS | Options::ENABLE_MATH;
        for event in TextMergeStream::new(Parser::new_ext(source, github)) {
            match event {
                Event::Text(text) | Event::Code(text) => said += &text,
                Event::Start(Tag::Paragraph) | Event::End(TagEnd::Paragraph) => {}
                other => return Err(format!("{other:?} in {source:?}")),
            }
        }
        Ok(said)
    }

    /// Blanks at the ends of lines are the writer's, and several are one to the reader.
    fn words(text: &str) -> String {
        text.split_whitespace().collect::<Vec<_>>().join(" ")
    }

    proptest! {
        #[test]
        fn text_is_nothing_but_text(text in hostile::text()) {
            // In the middle of a sentence, where all of it stands.
            let said = plain(&format!("x{}x", markdown(&text)));
            let shown = visible(&text.replace(['\n', '\r'], " "), |_| false);
            prop_assert_eq!(said.map(|said| words(&said)), Ok(words(&format!("x{shown}x"))));
        }

        #[test]
        fn code_is_nothing_but_code(text in hostile::text()) {
            let source = format!("x{}x", markdown_code(&text));
            let events: Vec<_> = TextMergeStream::new(Parser::new(&source)).collect();
            let [_, _, Event::Code(code), _, _] = &events[..] else { panic!("{events:?}") };
            let shown = visible(&text, |_| false);
            prop_assert_eq!(words(code), words(&shown));
        }

        #[test]
        fn nothing_ends_the_fence(text in hostile::text()) {
            let source = markdown_fenced(&text) + "\nafter";
            let events: Vec<_> = TextMergeStream::new(Parser::new(&source)).collect();
            prop_assert!(matches!(&events[0], Event::Start(Tag::CodeBlock(_))));
            let end = events.iter().position(|event| matches!(event, Event::End(TagEnd::CodeBlock))).unwrap();
            prop_assert!(end <= 2 && matches!(&events[end + 2], Event::Text(text) if &**text == "after"), "{:?}", events);
        }
    }
}
