//! A message about a place in a file, drawn like a compiler does.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use super::codes::Code;
use files::escape::{terminal, terminal_line, terminal_same_bytes};
use scenario::Origin;

/// A titled message that points at one place.
#[derive(Debug, Clone, Copy)]
pub struct Excerpt<'a> {
    /// What is wrong.
    pub title: &'a str,
    /// The place, with its line.
    pub origin: &'a Origin,
    /// Written under the marked part.
    pub label: &'a str,
    /// What has to be known besides, a sentence each.
    pub notes: &'a [String],
    /// What to do about it.
    pub help: Option<&'a str>,
}

impl Excerpt<'_> {
    /// The drawing; without `colour` it is plain text that is the same everywhere.
    pub fn render(&self, colour: bool) -> String {
        self.render_as(None, colour)
    }

    /// The same of an error that has a code.
    pub fn render_as(&self, code: Option<Code>, colour: bool) -> String {
        let line = terminal_same_bytes(&self.origin.source_line);
        let offset = |column: usize| line.char_indices().nth(column).map_or(line.len(), |(index, _)| index);
        let from = offset(self.origin.column.saturating_sub(1));
        let to = offset(self.origin.column.saturating_sub(1) + self.origin.length.max(1)).max(from);
        let snippet = Snippet::source(line)
            .line_start(self.origin.line.max(1))
            .path(terminal_line(&self.origin.file))
            .annotation(AnnotationKind::Primary.span(from..to).label(terminal_line(self.label)));
        let title = Level::ERROR.primary_title(terminal(self.title));
        let title = match code {
            Some(code) => title.id(code.name()),
            None => title,
        };
        let mut group = Group::with_title(title).element(snippet);
        for note in self.notes {
            group = group.element(Level::NOTE.message(terminal(note)));
        }
        if let Some(help) = self.help {
            group = group.element(Level::HELP.message(terminal(help)));
        }
        let renderer = if colour { Renderer::styled() } else { Renderer::plain() };
        renderer.render(&[group]).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_at_the_place() {
        let origin = Origin {
            file: "zebra.scn".into(),
            line: 21,
            column: 5,
            source_line: "    pet >= 1.5 s".into(),
            length: 12,
        };
        let excerpt = Excerpt {
            title: "`pet >= 1.5 s` failed in 2 of 20 runs",
            origin: &origin,
            label: "smallest 0.83 s",
            notes: &["worst run: zebra/x/rep=7".to_string()],
            help: Some("replay it"),
        };
        insta::assert_snapshot!(excerpt.render(false));
    }
}
