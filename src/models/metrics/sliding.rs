//! A speed signal seen through a sliding window, exactly: linear between its vertices.

use std::collections::VecDeque;

/// A piecewise linear signal and its values at fixed delays.
///
/// Between two breakpoints (moments at which the signal or a delayed copy of it has a vertex) every difference of
/// delayed values is linear in time. So extremes lie at breakpoints, and looking at those alone is exact for any
/// simulation step. Before its first vertex the signal is constant, as a run starts in steady cruise.
#[derive(Debug, Clone)]
pub struct Sliding<const DELAYS: usize> {
    /// Time (s) and value.
    vertices: VecDeque<(f64, f64)>,
    /// Rising delays (s), each with the index of the vertex at or before the present minus the delay.
    taps: [(f64, usize); DELAYS],
}

impl<const DELAYS: usize> Sliding<DELAYS> {
    /// `delays` (s) must rise; `step` (s) is how far apart most vertices are.
    pub fn new(delays: [f64; DELAYS], step: f64) -> Self {
        let longest = delays.last().copied().unwrap_or(0.0);
        // A signal may have a vertex inside a step, so two per step.
        let capacity = 2 * (longest / step).ceil() as usize + 8;
        Self { vertices: VecDeque::with_capacity(capacity), taps: delays.map(|delay| (delay, 0)) }
    }

    /// The signal goes on straight from `from` to `to` (time in s, value). `visit` gets every breakpoint up to and
    /// with `to`: its time, the value there, and the delayed values.
    pub fn advance(
        &mut self,
        from: (f64, f64),
        to: (f64, f64),
        mut visit: impl FnMut(f64, f64, [f64; DELAYS]),
    ) {
        if self.vertices.is_empty() {
            let longest = self.taps.last().map_or(0.0, |tap| tap.0);
            self.vertices.push_back((from.0 - 2.0 * longest, from.1));
            self.vertices.push_back(from);
        }
        self.vertices.push_back(to);
        loop {
            let upcoming = |tap: &(f64, usize)| self.vertices[tap.1 + 1].0 + tap.0;
            let next = self.taps.iter().map(upcoming).fold(f64::INFINITY, f64::min);
            let now = next.min(to.0);
            if now > from.0 {
                let value = if now == to.0 { to.1 } else { between(from, to, now) };
                let mut delayed = [0.0; DELAYS];
                for (delayed, &(delay, index)) in delayed.iter_mut().zip(&self.taps) {
                    *delayed = between(self.vertices[index], self.vertices[index + 1], now - delay);
                }
                visit(now, value, delayed);
            }
            if next >= to.0 {
                break;
            }
            for tap in &mut self.taps {
                if self.vertices[tap.1 + 1].0 + tap.0 <= now {
                    tap.1 += 1;
                }
            }
        }
        while self.taps.iter().all(|tap| tap.1 > 0) {
            self.vertices.pop_front();
            for tap in &mut self.taps {
                tap.1 -= 1;
            }
        }
    }
}

fn between(from: (f64, f64), to: (f64, f64), time: f64) -> f64 {
    let span = to.0 - from.0;
    if span <= 0.0 { to.1 } else { from.1 + ((time - from.0) / span).clamp(0.0, 1.0) * (to.1 - from.1) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn breakpoints_of_signal_and_delayed_signal_are_visited() {
        let mut window = Sliding::new([0.3], 1.0);
        let mut seen = Vec::new();
        let vertices = [(0.0, 8.0), (1.0, 8.0), (1.1, 7.0), (2.0, 7.0)];
        for pair in vertices.windows(2) {
            window.advance(pair[0], pair[1], |time, value, [delayed]| seen.push((time, value, delayed)));
        }
        let rounded: Vec<_> = seen
            .into_iter()
            .map(|(t, v, d): (f64, f64, f64)| ((t * 1e6).round() / 1e6, (v * 1e6).round() / 1e6, d))
            .collect();
        let expected = [(0.3, 8.0, 8.0), (1.0, 8.0, 8.0), (1.1, 7.0, 8.0), (1.3, 7.0, 8.0)];
        for point in expected {
            assert!(rounded.contains(&point), "{point:?} in {rounded:?}");
        }
        assert_eq!(rounded.last(), Some(&(2.0, 7.0, 7.0)));
    }

    #[test]
    fn the_buffer_does_not_grow() {
        let mut window = Sliding::new([0.2, 0.4], 0.025);
        let room = window.vertices.capacity();
        for k in 0..10_000 {
            let (t0, t1) = (f64::from(k) * 0.025, f64::from(k + 1) * 0.025);
            window.advance((t0, 1.0), (0.5 * (t0 + t1), 1.0), |_, _, _| {});
            window.advance((0.5 * (t0 + t1), 1.0), (t1, 1.0), |_, _, _| {});
        }
        assert_eq!(window.vertices.capacity(), room);
    }
}
