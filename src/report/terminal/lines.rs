//! Lines on their way to the terminal, and what did not pass among them.

/// Lines that are written or about to be.
#[derive(Debug)]
pub(super) struct Lines {
    pub colour: bool,
    /// Not written yet.
    pub text: String,
    /// Written or about to be.
    pub count: usize,
    /// Whether the last of them is empty.
    gap: bool,
}

/// A unit that did not pass.
#[derive(Debug)]
pub(super) struct Bad {
    pub key: String,
    pub line: String,
    /// All there is to say about it.
    pub text: String,
    /// The number of the last line of that; `None` if it was not shown.
    pub shown: Option<usize>,
}

impl Lines {
    pub fn new(colour: bool) -> Self {
        Self { colour, text: String::new(), count: 0, gap: true }
    }

    pub fn say(&mut self, line: &str) {
        self.count += 1 + line.matches('\n').count();
        self.gap = line.is_empty() || line.ends_with('\n');
        self.text.push_str(line);
        self.text.push('\n');
    }

    /// An empty line, unless there is one already.
    pub fn gap(&mut self) {
        if !self.gap {
            self.say("");
        }
    }
}
