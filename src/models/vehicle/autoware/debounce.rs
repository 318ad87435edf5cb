//! A condition that counts only after it has held for a while, and keeps counting for a while after.

/// Absorbs the rounding of sums of periods, s.
const TOLERANCE: f64 = 1e-6;

#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Delays {
    /// s
    pub on: f64,
    /// s
    pub off: f64,
}

#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Debounce {
    active: bool,
    /// Since when the raw condition has differed from `active`, s.
    differs_since: Option<f64>,
}

impl Debounce {
    /// Takes the raw condition at `time` (s) and says whether it counts.
    pub fn update(&mut self, raw: bool, time: f64, delays: Delays) -> bool {
        if raw == self.active {
            self.differs_since = None;
            return self.active;
        }
        let since = *self.differs_since.get_or_insert(time);
        let delay = if raw { delays.on } else { delays.off };
        if time - since >= delay - TOLERANCE {
            self.active = raw;
            self.differs_since = None;
        }
        self.active
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn needs_persistence_both_ways() {
        let mut debounce = Debounce::default();
        let raw = [true, true, false, true, true, true, true, false, false, true, false, false, false, false];
        let seen: Vec<_> = raw
            .iter()
            .enumerate()
            .map(|(k, &raw)| debounce.update(raw, k as f64 * 0.1, Delays { on: 0.3, off: 0.2 }))
            .collect();
        let on: Vec<_> = (0..seen.len()).filter(|&k| seen[k]).collect();
        assert_eq!(on, [6, 7, 8, 9, 10, 11]);
    }

    #[test]
    fn no_delay_is_no_delay() {
        let mut debounce = Debounce::default();
        assert!(debounce.update(true, 0.0, Delays { on: 0.0, off: 0.0 }));
        assert!(!debounce.update(false, 0.0, Delays { on: 0.0, off: 0.0 }));
    }
}
