//! What is wrong with a text, as data.

use super::codes::{Code, Severity};
use super::source::Span;

/// More findings than this are of no use to anybody and are not listed.
pub const MOST_FINDINGS: usize = 1000;

/// A place with words about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Label {
    /// Where.
    pub span: Span,
    /// What is to be said of the place; empty where marking it says enough.
    pub text: String,
}

/// What an editor can do about a finding at its first place.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Remedy {
    /// Something else in its place.
    Replace(String),
    /// Something more behind it.
    AddBehind(String),
    /// A statement more in the block of what has this name.
    SayInside(String),
    /// Without the statement, setting or character that stands there.
    Remove,
}

/// One finding: the first label is where it is, the others belong to the story.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// What it is about; `scenario-runner explain` has more.
    pub code: Code,
    /// As its code has it.
    pub severity: Severity,
    /// What is wrong, in a sentence without a full stop.
    pub message: String,
    /// Never empty.
    pub labels: Vec<Label>,
    /// What has to be known besides, a sentence each.
    pub notes: Vec<String>,
    /// What to do about it, a sentence each.
    pub hints: Vec<String>,
    /// What of that an editor can do, each by itself.
    pub remedies: Vec<Remedy>,
}

impl Diagnostic {
    /// A finding at one place, with nothing more to be said.
    pub fn new(code: Code, span: Span, message: impl Into<String>) -> Self {
        Self {
            code,
            severity: code.severity(),
            message: message.into(),
            labels: vec![Label { span, text: String::new() }],
            notes: Vec::new(),
            hints: Vec::new(),
            remedies: Vec::new(),
        }
    }

    /// The words under the mark.
    pub fn label(mut self, text: impl Into<String>) -> Self {
        self.labels[0].text = text.into();
        self
    }

    /// Another place that belongs to it.
    pub fn context(mut self, span: Span, text: impl Into<String>) -> Self {
        self.labels.push(Label { span, text: text.into() });
        self
    }

    /// With something to be known besides.
    pub fn note(mut self, text: impl Into<String>) -> Self {
        self.notes.push(text.into());
        self
    }

    /// With something to be done about it.
    pub fn hint(mut self, text: impl Into<String>) -> Self {
        self.hints.push(text.into());
        self
    }

    /// With something that an editor can do about it.
    pub fn remedy(mut self, remedy: Remedy) -> Self {
        self.remedies.push(remedy);
        self
    }

    /// "did you mean" when a name is near, else the list of names.
    pub fn suggest<'a>(self, found: &str, valid: impl IntoIterator<Item = &'a str>) -> Self {
        let mut valid: Vec<&str> = valid.into_iter().collect();
        if let Some(near) = nearest(found, valid.iter().copied()) {
            let near = near.to_string();
            return self.hint(format!("did you mean `{near}`?")).remedy(Remedy::Replace(near));
        }
        valid.sort_unstable();
        valid.dedup();
        const MOST: usize = 12;
        let listed: Vec<_> = valid.iter().take(MOST).map(|name| format!("`{name}`")).collect();
        match valid.len() {
            0 => self.hint("there is none to choose from here"),
            1 => self.hint(format!("there is only {}", listed.join(", "))),
            count if count > MOST => {
                self.hint(format!("there are {}, … ({} in all)", listed.join(", "), count))
            }
            _ => self.hint(format!("there are {}", listed.join(", "))),
        }
    }

    /// Where it is.
    pub fn span(&self) -> Span {
        self.labels[0].span
    }
}

/// The name nearest to what was written, if any is near enough to be meant.
pub fn nearest<'a>(found: &str, valid: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    /// Comparing takes time and memory by the product of two lengths; nobody mistypes a name of this many bytes.
    const LONGEST: usize = 100;
    /// Comparing every unknown name with every known one takes for ever in a text of a megabyte.
    const MOST: usize = 1000;
    if found.len() > LONGEST {
        return None;
    }
    let lower = found.to_lowercase();
    valid
        .into_iter()
        .filter(|name| name.len() <= LONGEST)
        .take(MOST)
        .map(|name| (strsim::damerau_levenshtein(&lower, &name.to_lowercase()), name))
        .filter(|(distance, name)| *distance <= name.len().max(found.len()).div_ceil(3))
        .min_by_key(|(distance, name)| (*distance, *name))
        .map(|(_, name)| name)
}
