//! A YAML document with the place of every value.

use saphyr_parser::{Event, Parser, ScalarStyle, Span as Mark};

use crate::codes::Code;
use crate::diagnostic::Diagnostic;
use crate::source::{SourceId, Span};
use crate::syntax::DEEPEST_NESTING;

/// A value and the bytes it was read from.
#[derive(Debug, Clone)]
pub struct Yaml {
    pub value: Content,
    pub start: usize,
    pub end: usize,
}

#[derive(Debug, Clone)]
pub enum Content {
    Scalar(String),
    List(Vec<Yaml>),
    /// Keys are scalars and unique.
    Mapping(Vec<(Yaml, Yaml)>),
}

impl Yaml {
    pub fn span(&self, source: SourceId) -> Span {
        Span::new(source, self.start, self.end)
    }

    pub fn scalar(&self) -> Option<&str> {
        match &self.value {
            Content::Scalar(text) => Some(text),
            _ => None,
        }
    }
}

/// Reads the one document of a text.
pub fn read(source: SourceId, text: &str) -> Result<Yaml, Box<Diagnostic>> {
    let offsets: Vec<usize> = text.char_indices().map(|(at, _)| at).chain([text.len()]).collect();
    let byte = |index: usize| offsets.get(index).copied().unwrap_or(text.len());
    let range = |mark: Mark| (byte(mark.start.index()), byte(mark.end.index()));
    let bad = |(start, end): (usize, usize), message: String, hint: &str| {
        let found = Diagnostic::new(Code::BadYaml, Span::new(source, start, end.max(start)), message);
        Box::new(found.label("here").hint(hint))
    };
    let mut open: Vec<Yaml> = Vec::new();
    let mut root: Option<Yaml> = None;
    // The keys that wait for their values, one for each open mapping.
    let mut keys: Vec<Option<Yaml>> = Vec::new();
    for event in Parser::new_from_str(text) {
        let (event, mark) = event.map_err(|error| {
            let at = byte(error.marker().index());
            bad((at, at), format!("this is not YAML: {}", error.info()), "is the indentation right?")
        })?;
        let place = range(mark);
        let refuse = "write the value out; scenario files know no anchors, aliases and tags";
        let value = match event {
            Event::Alias(_) => return Err(bad(place, "an alias".to_string(), refuse)),
            Event::Scalar(_, _, anchor, ref tag) if anchor != 0 || tag.is_some() => {
                return Err(bad(place, "an anchor or tag".to_string(), refuse));
            }
            Event::SequenceStart(anchor, ref tag) | Event::MappingStart(anchor, ref tag)
                if anchor != 0 || tag.is_some() =>
            {
                return Err(bad(place, "an anchor or tag".to_string(), refuse));
            }
            Event::Scalar(text, style, ..) => {
                let quote =
                    usize::from(matches!(style, ScalarStyle::SingleQuoted | ScalarStyle::DoubleQuoted));
                let (start, end) = (place.0 + quote, place.1.saturating_sub(quote));
                Yaml { value: Content::Scalar(text.into_owned()), start, end: end.max(start) }
            }
            Event::SequenceStart(..) | Event::MappingStart(..) => {
                if open.len() >= DEEPEST_NESTING {
                    return Err(bad(
                        place,
                        "nested too deeply".to_string(),
                        "no scenario needs this many levels",
                    ));
                }
                let value = match event {
                    Event::SequenceStart(..) => Content::List(Vec::new()),
                    _ => Content::Mapping(Vec::new()),
                };
                keys.push(None);
                open.push(Yaml { value, start: place.0, end: place.1 });
                continue;
            }
            Event::SequenceEnd | Event::MappingEnd => {
                keys.pop();
                let Some(done) = open.pop() else { continue };
                done
            }
            Event::DocumentStart(_) if root.is_some() => {
                return Err(bad(place, "a second document".to_string(), "put it into a file of its own"));
            }
            _ => continue,
        };
        let end = value.end;
        match open.last_mut() {
            None => root = Some(value),
            Some(parent) => {
                parent.end = parent.end.max(end);
                match &mut parent.value {
                    Content::List(items) => items.push(value),
                    Content::Mapping(fields) => match keys.last_mut().and_then(Option::take) {
                        Some(key) => fields.push((key, value)),
                        None => {
                            let Some(name) = value.scalar() else {
                                return Err(bad(
                                    (value.start, end),
                                    "a key that is no word".to_string(),
                                    "keys are words",
                                ));
                            };
                            if fields.iter().any(|(known, _)| known.scalar() == Some(name)) {
                                let message = format!("`{name}` stands here twice");
                                return Err(bad((value.start, end), message, "remove one of them"));
                            }
                            if let Some(waiting) = keys.last_mut() {
                                *waiting = Some(value);
                            }
                        }
                    },
                    Content::Scalar(_) => {}
                }
            }
        }
    }
    root.ok_or_else(|| bad((0, 0), "the file is empty".to_string(), "add `scenarios:`"))
}
