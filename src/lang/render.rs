//! Diagnostics as text for people, in the look of rustc.

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};

use super::codes::Severity;
use super::diagnostic::{Diagnostic, Label};
use super::source::{SourceId, Sources};
use files::escape::{terminal, terminal_line, terminal_same_bytes};

/// Marks in lines longer than this are shown in a window around them.
const LONGEST_LINE: usize = 300;

/// How diagnostics are shown.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Style {
    /// Whether escape sequences of terminals colour it.
    pub colour: bool,
}

/// One diagnostic, without a final line end.
pub fn render(diagnostic: &Diagnostic, sources: &Sources, style: Style) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let mut group =
        Group::with_title(level.primary_title(terminal(&diagnostic.message)).id(diagnostic.code.name()));
    let mut shown: Vec<SourceId> = Vec::new();
    for label in &diagnostic.labels {
        if !shown.contains(&label.span.source) {
            shown.push(label.span.source);
            group = group.elements(snippets(diagnostic, label.span.source, sources));
        }
    }
    for note in &diagnostic.notes {
        group = group.element(Level::NOTE.message(terminal(note)));
    }
    for hint in &diagnostic.hints {
        group = group.element(Level::HELP.message(terminal(hint)));
    }
    let renderer = if style.colour { Renderer::styled() } else { Renderer::plain() };
    renderer.render(&[group])
}

/// All diagnostics one after the other and a last line that counts them.
pub fn render_all(diagnostics: &[Diagnostic], sources: &Sources, style: Style) -> String {
    let mut text = String::new();
    for diagnostic in diagnostics {
        text.push_str(&render(diagnostic, sources, style));
        text.push_str("\n\n");
    }
    text.push_str(&count(diagnostics.iter().map(|diagnostic| diagnostic.severity)));
    text.push('\n');
    text
}

/// Such as `2 errors, 1 warning`.
pub fn count(severities: impl Iterator<Item = Severity>) -> String {
    let (mut errors, mut warnings) = (0, 0);
    for severity in severities {
        match severity {
            Severity::Error => errors += 1,
            Severity::Warning => warnings += 1,
        }
    }
    let part = |count: usize, word: &str| match count {
        0 => None,
        1 => Some(format!("1 {word}")),
        _ => Some(format!("{count} {word}s")),
    };
    let parts: Vec<_> = [part(errors, "error"), part(warnings, "warning")].into_iter().flatten().collect();
    if parts.is_empty() { "no errors".to_string() } else { parts.join(", ") }
}

/// Bytes from and to with the marks in them, numbered as in the diagnostic.
type Piece<'a> = (usize, usize, Vec<(usize, &'a Label)>);

/// The marked lines of one text. Marks far apart get their own piece so that only their lines are laid out.
fn snippets<'a>(
    diagnostic: &'a Diagnostic,
    source: SourceId,
    sources: &'a Sources,
) -> Vec<Snippet<'a, annotate_snippets::Annotation<'a>>> {
    let text = sources.get(source);
    let mut labels: Vec<(usize, &Label)> =
        diagnostic.labels.iter().enumerate().filter(|(_, label)| label.span.source == source).collect();
    // The primary mark's place is what a terminal links to, so its piece comes first.
    labels.sort_by_key(|(index, label)| (*index != 0, label.span.start));
    let mut pieces: Vec<Piece> = Vec::new();
    for (index, label) in labels {
        let (start, lines) = text.lines_around(label.span.start, label.span.end);
        let end = start + lines.len();
        const NEAR: usize = 2000;
        match pieces.last_mut() {
            Some((from, to, inside)) if start.abs_diff(*from) < NEAR && end.abs_diff(*to) < NEAR => {
                *from = start.min(*from);
                *to = end.max(*to);
                inside.push((index, label));
            }
            _ => pieces.push((start, end, vec![(index, label)])),
        }
    }
    pieces
        .into_iter()
        .map(|(mut start, mut end, labels)| {
            let first_line = text.location(start).line;
            if end - start > 2 * LONGEST_LINE && labels.len() == 1 {
                let span = labels[0].1.span;
                let floor =
                    |at: usize| (0..=at).rev().find(|at| text.text.is_char_boundary(*at)).unwrap_or(0);
                if span.end - span.start <= LONGEST_LINE {
                    start = start.max(floor(span.start.saturating_sub(LONGEST_LINE / 2)));
                    end = end.min(floor((span.end + LONGEST_LINE / 2).min(text.text.len())));
                }
            }
            let mut snippet = Snippet::source(terminal_same_bytes(&text.text[start..end]))
                .line_start(first_line)
                .path(terminal_line(&text.name))
                .fold(true);
            for (index, label) in labels {
                let kind = if index == 0 { AnnotationKind::Primary } else { AnnotationKind::Context };
                let from = label.span.start - start;
                let mark = kind.span(from..(label.span.end.min(end) - start).max(from));
                snippet = snippet.annotation(if label.text.is_empty() {
                    mark
                } else {
                    mark.label(terminal_line(&label.text))
                });
            }
            snippet
        })
        .collect()
}
