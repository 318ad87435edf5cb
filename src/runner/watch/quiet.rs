//! Since when nothing changes any more: who saves several files should be waited for.

use std::time::Duration;

/// Changes count as one until nothing has changed for so long.
const PAUSE: Duration = Duration::from_millis(150);
/// Whatever goes on changing is not waited for longer than this.
const LONGEST: Duration = Duration::from_secs(2);

/// Whether changes go on. Times are since some beginning, and do not go back.
#[derive(Debug, Clone, Copy, Default)]
pub struct Quiet {
    /// The first change and the last of those that are waited for.
    changes: Option<(Duration, Duration)>,
}

impl Quiet {
    /// Something changed.
    pub fn disturbed(&mut self, now: Duration) {
        let first = self.changes.map_or(now, |(first, _)| first);
        self.changes = Some((first, now));
    }

    /// How long it still has to be waited; nothing where it is quiet.
    pub fn left(&self, now: Duration) -> Duration {
        let Some((first, last)) = self.changes else { return Duration::ZERO };
        (last + PAUSE).min(first + LONGEST).saturating_sub(now)
    }

    /// What changed has been seen to.
    pub fn settled(&mut self) {
        self.changes = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn changes_that_follow_each_other_are_one() {
        let mut quiet = Quiet::default();
        assert_eq!(quiet.left(ms(0)), Duration::ZERO);
        quiet.disturbed(ms(1000));
        assert_eq!(quiet.left(ms(1100)), ms(50));
        quiet.disturbed(ms(1100));
        assert_eq!(quiet.left(ms(1200)), ms(50));
        assert_eq!(quiet.left(ms(1250)), Duration::ZERO);
        quiet.settled();
        quiet.disturbed(ms(9000));
        assert_eq!(quiet.left(ms(9000)), PAUSE);
    }

    #[test]
    fn what_never_stops_changing_is_not_waited_for_for_ever() {
        let mut quiet = Quiet::default();
        (0..100).for_each(|change| quiet.disturbed(ms(100 * change)));
        assert_eq!(quiet.left(ms(1990)), ms(10));
        assert_eq!(quiet.left(ms(2000)), Duration::ZERO);
    }
}
