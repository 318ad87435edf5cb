//! Where things were said, among the files that were read.

use std::path::Path;

use crate::source::Span;
use crate::texts::{Texts, join};
use scenario::Origin;

/// Where things were said.
#[derive(Clone, Copy)]
pub struct TextPlaces<'a> {
    pub files: &'a Texts<'a>,
}

impl TextPlaces<'_> {
    pub fn origin(&self, span: Span) -> Origin {
        self.files.sources.origin(span)
    }

    /// The path of a file that is named relative to the file in which `span` is.
    pub fn beside(&self, span: Span, name: &str) -> String {
        let file = Path::new(&self.files.sources.get(span.source).name);
        join(file, name).display().to_string()
    }
}
