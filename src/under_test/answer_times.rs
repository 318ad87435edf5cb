//! How long programs take to answer: wall time of an answer for each run of its request, counted in classes of about 1 %.

use std::time::Duration;

/// Classes between a time and twice that time.
const CLASSES: usize = 64;

/// Powers of two of nanoseconds.
const POWERS: usize = 64;

/// Wall times of answers. They depend on the machine: no result does.
#[derive(Debug, Clone)]
pub struct AnswerClock {
    classes: Vec<u64>,
    answers: u64,
    worst: Duration,
    late: u64,
}

impl Default for AnswerClock {
    fn default() -> Self {
        Self { classes: vec![0; CLASSES * POWERS], answers: 0, worst: Duration::ZERO, late: 0 }
    }
}

impl AnswerClock {
    /// Takes note of a request for so many runs that was answered in `time`; for `late` of them that is longer than it may take.
    pub fn note(&mut self, time: Duration, runs: usize, late: usize) {
        let each = time / u32::try_from(runs.max(1)).unwrap_or(u32::MAX);
        self.classes[class(each)] += runs as u64;
        self.answers += runs as u64;
        self.late += late as u64;
        self.worst = self.worst.max(each);
    }

    /// Takes in what another one has counted.
    pub fn add(&mut self, other: &Self) {
        self.classes.iter_mut().zip(&other.classes).for_each(|(one, more)| *one += more);
        self.answers += other.answers;
        self.late += other.late;
        self.worst = self.worst.max(other.worst);
    }

    /// How many answers there were.
    pub fn answers(&self) -> u64 {
        self.answers
    }

    /// The longest time.
    pub fn worst(&self) -> Duration {
        self.worst
    }

    /// The share of answers that came late (0..1); 0 without any.
    pub fn late(&self) -> f64 {
        self.late as f64 / self.answers.max(1) as f64
    }

    /// A time that this share of answers (0..1) does not exceed, to about 1 %; zero without any.
    pub fn quantile(&self, share: f64) -> Duration {
        let wanted = (share * self.answers as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        let found = self.classes.iter().position(|count| {
            seen += count;
            seen >= wanted
        });
        found.map_or(Duration::ZERO, |class| upper(class).min(self.worst))
    }
}

/// The class of a time.
fn class(time: Duration) -> usize {
    let nanoseconds = u64::try_from(time.as_nanos()).unwrap_or(u64::MAX).max(1);
    let power = nanoseconds.ilog2() as usize;
    let above = nanoseconds - (1 << power);
    // Below 64 ns there are fewer whole numbers than classes.
    power * CLASSES + ((u128::from(above) * CLASSES as u128) >> power) as usize
}

/// The longest time of a class.
fn upper(class: usize) -> Duration {
    let (power, part) = (class / CLASSES, (class % CLASSES + 1) as f64);
    Duration::from_secs_f64((1_u64 << power) as f64 * (1.0 + part / CLASSES as f64) / 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_right_to_a_hundredth() {
        let mut clock = AnswerClock::default();
        (1..=1000).for_each(|micros| clock.note(Duration::from_micros(micros), 1, usize::from(micros > 900)));
        for (share, micros) in [(0.5, 500.0), (0.99, 990.0), (0.01, 10.0)] {
            let found = clock.quantile(share).as_secs_f64() * 1e6;
            assert!((found / micros - 1.0).abs() < 0.02, "{share}: {found} µs");
        }
        assert_eq!((clock.worst(), clock.late()), (Duration::from_millis(1), 0.1));
        assert_eq!(clock.quantile(1.0), clock.worst());
    }

    #[test]
    fn a_request_for_many_counts_as_many() {
        let (mut one, mut all) = (AnswerClock::default(), AnswerClock::default());
        one.note(Duration::from_millis(64), 64, 0);
        all.add(&one);
        all.add(&one);
        assert_eq!((all.answers(), all.worst()), (128, Duration::from_millis(1)));
        assert_eq!(AnswerClock::default().quantile(0.5), Duration::ZERO);
        let nanoseconds = [0, 1, 2, 3, 63, 64, 65, u64::MAX];
        assert!(
            nanoseconds
                .windows(2)
                .all(|two| { class(Duration::from_nanos(two[0])) <= class(Duration::from_nanos(two[1])) })
        );
    }
}
