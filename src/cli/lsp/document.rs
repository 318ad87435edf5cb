//! Documents as an editor holds them: their texts, kept within bounds, and places in them.

use std::path::PathBuf;

use lsp_types::{Position, Range, TextDocumentContentChangeEvent, Uri};

use lang::Span;
use report::findings::uri_path;

/// Larger documents are neither kept nor checked while they are edited, bytes.
pub const LARGEST: usize = 1 << 20;

/// Of all open documents together, bytes.
pub const LARGEST_TOGETHER: usize = 64 << 20;

/// More than these are not kept.
pub const MOST: usize = 1000;

/// An open document.
#[derive(Debug, Default)]
pub struct Document {
    /// As the editor counts.
    pub version: i32,
    /// Empty if it is refused.
    pub text: String,
    /// Why its text is not kept.
    pub refused: Option<String>,
}

impl Document {
    /// `room`: how many bytes more may be kept of all documents.
    pub fn new(version: i32, text: String, room: usize) -> Self {
        let size = text.len();
        let refused = if size > LARGEST {
            Some(format!(
                "this text has {size} bytes: while it is edited, only texts of up to {LARGEST} are checked"
            ))
        } else if size > room {
            Some(format!("more than {LARGEST_TOGETHER} bytes are open: this text is not checked"))
        } else {
            None
        };
        let text = if refused.is_some() { String::new() } else { text };
        Self { version, text, refused }
    }
}

/// A text after an editor's changes, in their order: each the whole text anew, or a part of it.
///
/// Parts change nothing of a text that is not kept: what the whole would be is not known then.
pub fn changed(mut text: String, changes: Vec<TextDocumentContentChangeEvent>) -> String {
    for change in changes {
        match change.range {
            None => text = change.text,
            Some(range) => {
                let (start, end) = (offset_of(&text, range.start), offset_of(&text, range.end));
                text.replace_range(start..end.max(start), &change.text);
            }
        }
    }
    text
}

pub fn range_of(text: &str, span: Span) -> Range {
    Range { start: position_of(text, span.start), end: position_of(text, span.end) }
}

/// Lines from 0, columns in UTF-16 units, as the protocol wants them.
pub fn position_of(text: &str, offset: usize) -> Position {
    let before = &text[..offset];
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    let line = before.matches('\n').count() as u32;
    Position { line, character: before[line_start..].encode_utf16().count() as u32 }
}

/// Positions in a text, of places that come one behind the other: each part of the text is gone through once.
pub struct Positions<'t> {
    text: &'t str,
    offset: usize,
    position: Position,
}

impl<'t> Positions<'t> {
    pub fn new(text: &'t str) -> Self {
        Self { text, offset: 0, position: Position::default() }
    }

    /// That of a byte, which is not before the last that was asked for.
    pub fn at(&mut self, offset: usize) -> Position {
        for character in self.text[self.offset..offset].chars() {
            if character == '\n' {
                self.position = Position { line: self.position.line + 1, character: 0 };
            } else {
                self.position.character += character.len_utf16() as u32;
            }
        }
        self.offset = offset;
        self.position
    }
}

pub fn offset_of(text: &str, position: Position) -> usize {
    let line_start = match position.line {
        0 => 0,
        line => match text.match_indices('\n').nth(line as usize - 1) {
            Some((at, _)) => at + 1,
            None => return text.len(),
        },
    };
    let mut units = position.character as usize;
    for (at, character) in text[line_start..].char_indices() {
        if units == 0 || character == '\n' {
            return line_start + at;
        }
        units = units.saturating_sub(character.len_utf16());
    }
    text.len()
}

/// The path of a `file:` address.
pub fn path_of(uri: &Uri) -> Option<PathBuf> {
    let encoded = uri.as_str().strip_prefix("file://")?;
    let mut bytes = Vec::with_capacity(encoded.len());
    let mut rest = encoded.as_bytes();
    while let [first, tail @ ..] = rest {
        let escaped =
            tail.get(..2).filter(|_| *first == b'%').and_then(|digits| std::str::from_utf8(digits).ok());
        match escaped.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &tail[2..];
            }
            None => {
                bytes.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8(bytes).ok().map(PathBuf::from)
}

pub fn uri_of(name: &str) -> Option<Uri> {
    let path = std::path::absolute(name).ok()?;
    format!("file://{}", uri_path(path.to_str()?)).parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_count_in_utf16() {
        let text = "a\n😀b\n";
        assert_eq!(position_of(text, 6), Position { line: 1, character: 2 });
        assert_eq!(offset_of(text, Position { line: 1, character: 2 }), 6);
        assert_eq!(offset_of(text, Position { line: 9, character: 0 }), text.len());
        assert_eq!(offset_of(text, Position { line: u32::MAX, character: u32::MAX }), text.len());
        let mut positions = Positions::new(text);
        for offset in [0, 1, 2, 6, 7, 8] {
            assert_eq!(positions.at(offset), position_of(text, offset));
        }
        // Between the halves of a character: behind it.
        assert_eq!(offset_of(text, Position { line: 1, character: 1 }), 6);
    }

    fn change(range: Option<[u32; 4]>, text: &str) -> TextDocumentContentChangeEvent {
        let range = range.map(|[line, character, last_line, last]| Range {
            start: Position { line, character },
            end: Position { line: last_line, character: last },
        });
        TextDocumentContentChangeEvent { range, range_length: None, text: text.into() }
    }

    #[test]
    fn changes_replace_the_whole_or_a_part_in_their_order() {
        let text = || "one\ntwo😀\nthree\n".to_string();
        assert_eq!(changed(text(), vec![change(None, "x"), change(Some([0, 0, 0, 1]), "y")]), "y");
        assert_eq!(changed(text(), vec![change(Some([1, 3, 2, 0]), " ")]), "one\ntwo three\n");
        // Behind the end, and with the end before the start.
        assert_eq!(changed(text(), vec![change(Some([9, 9, 9, 9]), "!")]), "one\ntwo😀\nthree\n!");
        assert_eq!(changed(text(), vec![change(Some([1, 1, 0, 0]), "!")]), "one\nt!wo😀\nthree\n");
        assert_eq!(changed(text(), Vec::new()), text());
    }

    #[test]
    fn texts_are_kept_within_bounds() {
        assert_eq!(Document::new(1, "a".into(), LARGEST).refused, None);
        let large = Document::new(1, "a".repeat(LARGEST + 1), LARGEST_TOGETHER);
        assert!(large.text.is_empty() && large.refused.is_some());
        let crowded = Document::new(1, "abc".into(), 2);
        assert!(crowded.text.is_empty() && crowded.refused.is_some());
    }
}
