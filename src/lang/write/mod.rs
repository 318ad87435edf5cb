//! The way back from what was checked to its text: what a file that stands alone is made of.
//!
//! What is read back is the same to the last bit: numbers are written in whichever unit gives them back exactly with the fewest
//! digits. What a block says is written beside where it is checked, since the one is the other backwards and both share what is
//! so where nothing is said. The table of statements does not write: it knows words, and none of the data that these stand for.
//! That nothing is forgotten is held by a test which writes and reads back every example of the table.

mod words;

use std::fmt::Write;

pub use words::{
    constant, is_name, model_text, number_of, quantity, quoted, settings_text, write_comparison,
};

/// Lines of blocks in blocks.
#[derive(Default)]
pub struct BlockText {
    pub text: String,
    depth: usize,
}

impl BlockText {
    pub fn line(&mut self, line: &str) {
        writeln!(self.text, "{}{line}", "  ".repeat(self.depth)).expect("writing to a string cannot fail");
    }

    pub fn open(&mut self, head: &str) {
        self.line(&format!("{head} {{"));
        self.depth += 1;
    }

    pub fn close(&mut self) {
        self.depth -= 1;
        self.line("}");
    }
}
