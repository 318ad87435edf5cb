//! A speed signal seen through a sliding window, exactly: linear between its vertices.

/// So many vertices that no delay reaches any more are forgotten at once.
const FORGOTTEN: usize = 64;

/// A piecewise linear signal and its values at fixed delays.
///
/// Between two breakpoints (moments at which the signal or a delayed copy of it has a vertex) every difference of
/// delayed values is linear in time. So extremes lie at breakpoints, and looking at those alone is exact for any
/// simulation step. Before its first vertex the signal is constant, as a run starts in steady cruise.
#[derive(Debug, Clone)]
pub struct Sliding<const DELAYS: usize> {
    /// Time (s) and value.
    vertices: Vec<(f64, f64)>,
    taps: [Tap; DELAYS],
}

/// A delayed copy of the signal.
#[derive(Debug, Clone, Copy)]
struct Tap {
    /// s
    delay: f64,
    /// Of the vertex at or before the present minus the delay.
    index: usize,
    /// When the copy comes to the vertex after that, s.
    next: f64,
}

impl<const DELAYS: usize> Sliding<DELAYS> {
    /// `delays` (s) must rise; `step` (s) is how far apart most vertices are.
    pub fn new(delays: [f64; DELAYS], step: f64) -> Self {
        let longest = delays.last().copied().unwrap_or(0.0);
        // A signal may have a vertex inside a step, so two per step.
        let capacity = 2 * (longest / step).ceil() as usize + 8 + FORGOTTEN;
        let taps = delays.map(|delay| Tap { delay, index: 0, next: f64::INFINITY });
        Self { vertices: Vec::with_capacity(capacity), taps }
    }

    /// The signal goes on straight from `from` to `to` (time in s, value). `visit` gets every breakpoint up to and
    /// with `to`: its time, the value there, and the delayed values.
    #[inline]
    pub fn advance(
        &mut self,
        from: (f64, f64),
        to: (f64, f64),
        mut visit: impl FnMut(f64, f64, [f64; DELAYS]),
    ) {
        if self.vertices.is_empty() {
            self.begin(from);
        }
        self.vertices.push(to);
        loop {
            let next = self.taps.iter().map(|tap| tap.next).fold(f64::INFINITY, f64::min);
            let now = next.min(to.0);
            if now > from.0 {
                let value = if now == to.0 { to.1 } else { between(from, to, now) };
                let delayed = self.taps.map(|tap| {
                    between(self.vertices[tap.index], self.vertices[tap.index + 1], now - tap.delay)
                });
                visit(now, value, delayed);
            }
            if next >= to.0 {
                break;
            }
            for tap in &mut self.taps {
                if tap.next <= now {
                    tap.index += 1;
                    tap.next = self.vertices[tap.index + 1].0 + tap.delay;
                }
            }
        }
        self.forget();
    }

    fn begin(&mut self, from: (f64, f64)) {
        let longest = self.taps.last().map_or(0.0, |tap| tap.delay);
        self.vertices.extend([(from.0 - 2.0 * longest, from.1), from]);
        self.taps.iter_mut().for_each(|tap| tap.next = from.0 + tap.delay);
    }

    fn forget(&mut self) {
        // The longest delay is the last one.
        let past = self.taps.last().map_or(0, |tap| tap.index);
        if past >= FORGOTTEN {
            self.vertices.drain(..past);
            self.taps.iter_mut().for_each(|tap| tap.index -= past);
        }
    }
}

#[inline]
fn between(from: (f64, f64), to: (f64, f64), time: f64) -> f64 {
    let (span, rise) = (to.0 - from.0, to.1 - from.1);
    if span <= 0.0 {
        to.1
    } else if rise == 0.0 {
        // The same number but for the sign of zero, without a division.
        from.1 + 0.0
    } else {
        from.1 + ((time - from.0) / span).clamp(0.0, 1.0) * rise
    }
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
