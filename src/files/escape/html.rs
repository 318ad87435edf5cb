//! Text in HTML, inside and outside of attributes.

use super::visible::{is_layout, push_visible, visible};

/// Text for a writer that escapes markup by itself: without characters that a page must not have or that turn it around.
pub fn html_characters(text: &str) -> String {
    visible(text, is_layout)
}

/// Text that is no markup wherever it stands between tags or between quotes, safe to be given to a browser.
pub fn html(text: &str) -> String {
    let mut plain = String::with_capacity(text.len());
    for letter in text.chars() {
        match letter {
            '&' => plain.push_str("&amp;"),
            '<' => plain.push_str("&lt;"),
            '>' => plain.push_str("&gt;"),
            '"' => plain.push_str("&quot;"),
            '\'' => plain.push_str("&#x27;"),
            _ => push_visible(&mut plain, letter, &is_layout),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use html5gum::{Token, Tokenizer};
    use proptest::prelude::*;

    use super::*;
    use crate::escape::hostile;

    proptest! {
        #[test]
        fn a_browser_reads_text_and_attributes_back(text in hostile::text()) {
            let page = format!("<p title=\"{0}\" class='{0}'>{0}</p>", html(&text));
            let shown = html_characters(&text).into_bytes();
            let mut said = Vec::new();
            for token in Tokenizer::new(&page) {
                match token.expect("reading a string cannot fail") {
                    Token::StartTag(tag) => {
                        prop_assert_eq!(&*tag.name, &b"p"[..]);
                        let values: Vec<_> = tag.attributes.values().map(|value| value.to_vec()).collect();
                        prop_assert_eq!(values, vec![shown.clone(), shown.clone()]);
                    }
                    Token::String(text) => said.extend_from_slice(&text),
                    Token::EndTag(tag) => prop_assert_eq!(&*tag.name, &b"p"[..]),
                    other => prop_assert!(false, "{other:?}"),
                }
            }
            prop_assert_eq!(said, shown);
        }
    }
}
