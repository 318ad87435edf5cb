//! A figure of the page: panels side by side, and more of them behind a fold.

use serde::Serialize;

use crate::chart::LegendEntry;
use crate::figures;

#[derive(Debug, Default, Serialize)]
pub struct HtmlFigure {
    pub title: String,
    /// How to read it.
    pub note: String,
    /// Swatch and words.
    pub legend: Vec<(String, String)>,
    /// SVG elements.
    pub panels: Vec<String>,
    /// What is behind the fold.
    pub more: Vec<String>,
    /// The words on it.
    pub fold: String,
}

impl HtmlFigure {
    pub fn new(title: impl Into<String>, note: impl Into<String>, panels: Vec<String>) -> Self {
        Self { title: title.into(), note: note.into(), panels, ..Self::default() }
    }

    pub fn with_legend(mut self, entries: Vec<LegendEntry>) -> Self {
        self.legend = entries.into_iter().map(|entry| (entry.swatch, entry.label)).collect();
        self
    }

    /// Leaves the first `open` panels to be seen and folds the others.
    pub fn folded(mut self, open: usize, fold: impl FnOnce(usize) -> String) -> Self {
        if self.panels.len() > open {
            self.more = self.panels.split_off(open);
            self.fold = fold(self.more.len());
        }
        self
    }
}

impl From<figures::Figure> for HtmlFigure {
    fn from(figure: figures::Figure) -> Self {
        Self::new(figure.title, figure.note, figure.panels).with_legend(figure.legend)
    }
}
