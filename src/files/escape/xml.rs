//! Text for XML documents, whose writer escapes markup by itself.

use super::visible::visible;

/// Text of several lines in which every character is one that XML 1.0 allows: without control characters, U+FFFE and U+FFFF.
pub fn xml(text: &str) -> String {
    visible(text, |letter| letter == '\n')
}

/// A name or an attribute: to a reader of XML line ends in it would be blanks.
pub fn xml_line(text: &str) -> String {
    visible(text, |_| false)
}
