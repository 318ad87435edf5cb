//! How long something still takes, as far as that is known.

use std::time::Duration;

use indicatif::HumanDuration;

/// How long something still takes, s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TimeLeft {
    pub least: f64,
    /// `None` where nobody knows.
    pub most: Option<f64>,
}

impl TimeLeft {
    /// Whether both ends are so near to each other that it is one time: neither is further than 30 % from the middle.
    pub fn is_one(self) -> bool {
        self.most.is_some_and(|most| most <= 1.3 * self.middle() && self.least >= 0.7 * self.middle())
    }

    /// Between both ends.
    pub fn middle(self) -> f64 {
        self.most.map_or(self.least, |most| (self.least + most) / 2.0)
    }

    /// To be appended: `, 9 seconds left`, `, 2 minutes to 5 minutes left`.
    pub fn in_words(self) -> String {
        let words =
            |seconds: f64| HumanDuration(Duration::from_secs_f64(seconds.clamp(0.0, 1e9))).to_string();
        if self.is_one() {
            return format!(", {} left", words(self.middle()));
        }
        let least = words(self.least);
        match self.most.map(words) {
            None => format!(", more than {least} left"),
            Some(most) if most == least => format!(", {least} left"),
            Some(most) => format!(", {least} to {most} left"),
        }
    }
}
