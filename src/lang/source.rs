//! The texts that were read, and places in them.

use std::sync::Arc;

use super::yaml::TranslatedPlaces;
use scenario::Origin;

/// One of the texts in [`Sources`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SourceId(pub(crate) u32);

/// Bytes `start..end` of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct Span {
    /// The text.
    pub source: SourceId,
    /// Of the first byte.
    pub start: usize,
    /// Behind the last byte; not before `start`.
    pub end: usize,
}

/// A text with the name it is shown under.
#[derive(Debug, Clone)]
pub struct Source {
    /// A path, or what stands for one.
    pub name: String,
    /// All of it, as it was read.
    pub text: Arc<str>,
    /// Byte offset of the first character of every line.
    line_starts: Vec<usize>,
    /// The text that this one was made from, and from where in it.
    original: Option<(SourceId, TranslatedPlaces)>,
}

/// Every text that a suite was read from.
#[derive(Debug, Clone, Default)]
pub struct Sources {
    sources: Vec<Source>,
}

/// A line and a column in it, both counted from 1; the column in characters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Location {
    /// In the text.
    pub line: usize,
    /// In the line.
    pub column: usize,
}

impl Source {
    fn new(name: String, text: Arc<str>) -> Self {
        let mut line_starts = vec![0];
        line_starts.extend(text.bytes().enumerate().filter(|(_, byte)| *byte == b'\n').map(|(at, _)| at + 1));
        Self { name, text, line_starts, original: None }
    }

    /// Index of the line that holds byte `offset`.
    fn line_index(&self, offset: usize) -> usize {
        self.line_starts.partition_point(|start| *start <= offset) - 1
    }

    /// Where the character is that begins at this byte.
    pub fn location(&self, offset: usize) -> Location {
        let line = self.line_index(offset);
        let column = self.text[self.line_starts[line]..offset].chars().count() + 1;
        Location { line: line + 1, column }
    }

    /// The line with index `line` without its end.
    fn line(&self, line: usize) -> &str {
        let end = self.line_starts.get(line + 1).copied().unwrap_or(self.text.len());
        self.text[self.line_starts[line]..end].trim_end_matches(['\n', '\r'])
    }

    /// The whole lines that hold bytes `start..end`, with the offset of their first byte.
    pub fn lines_around(&self, start: usize, end: usize) -> (usize, &str) {
        let from = self.line_starts[self.line_index(start)];
        let last = self.line_index(end);
        let to = self.line_starts.get(last + 1).copied().unwrap_or(self.text.len());
        (from, &self.text[from..to])
    }
}

impl Sources {
    /// Takes a text in, under the name that it is shown with.
    pub fn add(&mut self, name: impl Into<String>, text: impl Into<Arc<str>>) -> SourceId {
        let id = SourceId(self.sources.len() as u32);
        self.sources.push(Source::new(name.into(), text.into()));
        id
    }

    /// Adds a text that was made from another; places in it are shown in that one.
    pub fn add_translation(
        &mut self,
        text: String,
        original: SourceId,
        places: TranslatedPlaces,
    ) -> SourceId {
        let id = self.add(self.get(original).name.clone(), text);
        self.sources[id.0 as usize].original = Some((original, places));
        id
    }

    /// The place as its author knows it.
    pub fn resolve(&self, span: Span) -> Span {
        match &self.get(span.source).original {
            Some((source, places)) => {
                let (start, end) = places.original(span.start, span.end);
                Span { source: *source, start, end }
            }
            None => span,
        }
    }

    /// The text of this number.
    pub fn get(&self, id: SourceId) -> &Source {
        &self.sources[id.0 as usize]
    }

    /// All texts, in the order in which they were read.
    pub fn iter(&self) -> impl Iterator<Item = (SourceId, &Source)> {
        self.sources.iter().enumerate().map(|(index, source)| (SourceId(index as u32), source))
    }

    /// What stands there.
    pub fn text(&self, span: Span) -> &str {
        &self.get(span.source).text[span.start..span.end]
    }

    /// The first place of a span.
    pub fn location(&self, span: Span) -> Location {
        let span = self.resolve(span);
        self.get(span.source).location(span.start)
    }

    /// The place that travelled with a scenario, back in its text; `None` if it is from none of these.
    pub fn span(&self, origin: &Origin) -> Option<Span> {
        let (id, source) = self.iter().find(|(_, source)| *source.name == *origin.file)?;
        let start = *source.line_starts.get(origin.line.checked_sub(1)?)?;
        let offset = |characters: usize| {
            let rest = &source.text[start..];
            start + rest.char_indices().nth(characters).map_or(rest.len(), |(index, _)| index)
        };
        let column = origin.column.checked_sub(1)?;
        Some(Span::new(id, offset(column), offset(column + origin.length)))
    }

    /// The place as the data that travels with a scenario. Very long lines are not carried along.
    pub fn origin(&self, span: Span) -> Origin {
        const LONGEST_LINE: usize = 400;
        let span = self.resolve(span);
        let source = self.get(span.source);
        let index = source.line_index(span.start);
        let line = source.line(index);
        let Location { line: number, column } = source.location(span.start);
        let line_end = source.line_starts[index] + line.len();
        let marked = &source.text[span.start..span.end.min(line_end).max(span.start)];
        Origin {
            file: source.name.as_str().into(),
            line: number,
            column,
            source_line: if line.len() <= LONGEST_LINE { line.into() } else { Arc::default() },
            length: marked.chars().count().max(1),
        }
    }
}

impl Span {
    /// From byte `start` to before byte `end`.
    pub fn new(source: SourceId, start: usize, end: usize) -> Self {
        Self { source, start, end }
    }

    /// The empty place at the beginning of a text.
    pub fn beginning(source: SourceId) -> Self {
        Self::new(source, 0, 0)
    }

    /// From the beginning of this to the end of another span, which is of the same text.
    pub fn to(self, other: Self) -> Self {
        Self { end: other.end.max(self.end), ..self }
    }
}
