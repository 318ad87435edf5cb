//! The cost of looming: how fast the other grows in the eye on an anticipated collision course (§7.1).

use super::state::AgentBody;
use super::value::{ActionPhase, Discounting, Phases, SAMPLE_TIME};

/// What looming costs one individual.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoomingCost {
    /// Optical expansion rate at which the cost begins (rad/s).
    pub onset: f64,
    /// Optical expansion rate whose cost cancels travelling freely (rad/s).
    pub full: f64,
}

/// The anticipated movement of the one who looks.
#[derive(Clone, Copy, Debug)]
pub struct OwnTrack<'a> {
    /// Distance now (m).
    pub distance: f64,
    /// Its extent.
    pub body: &'a AgentBody,
    /// Its action.
    pub action: &'a ActionPhase,
    /// Acceleration of the achieve phase (m/s²).
    pub achieve: f64,
    /// The phases.
    pub phases: &'a Phases,
    /// Free speed (m/s).
    pub free_speed: f64,
    /// Time to regain it (s).
    pub regain_time: f64,
}

/// The anticipated movement of the one looked at.
#[derive(Clone, Copy, Debug)]
pub struct OtherTrack<'a> {
    /// Distance now (m).
    pub distance: f64,
    /// Speed now (m/s).
    pub speed: f64,
    /// Its extent.
    pub body: &'a AgentBody,
    /// Acceleration of the first sample (m/s²).
    pub first_acceleration: f64,
    /// Acceleration of every later sample (m/s²).
    pub later_acceleration: f64,
}

/// Samples that are excluded from collision courses together.
const BLOCK: usize = 32;

/// Samples worked on side by side.
const LANES: usize = 8;

/// A speed (m/s) so small that its sign is a matter of rounding.
const STANDSTILL: f64 = 1e-9;

/// A distance (m) too small to tell the edge of the conflict space by other sums than the published ones.
const EDGE: f64 = 1e-6;

impl Discounting {
    /// The looming part of the value: never positive.
    pub fn looming(&self, cost: &LoomingCost, own: &OwnTrack, other: &OtherTrack) -> f64 {
        if own.phases.integrated == 0 {
            return 0.0;
        }
        let smooth = OwnPath::new(own)
            .zip(OtherPath::new(other))
            .and_then(|(own_path, other_path)| self.along_paths(cost, own, other, &own_path, &other_path));
        let sum = smooth.unwrap_or_else(|| self.sample_by_sample(cost, own, other));
        -SAMPLE_TIME * sum / (cost.full - cost.onset)
    }

    /// Σ of the discounted excess over the blocks in which a collision course is possible. `None` where rounding
    /// decides.
    fn along_paths(
        &self,
        cost: &LoomingCost,
        own: &OwnTrack,
        other: &OtherTrack,
        own_path: &OwnPath,
        other_path: &OtherPath,
    ) -> Option<f64> {
        let sight = Sight::new(cost, own, other);
        // The first sample has an acceleration of the other of its own.
        let mut sum = sight.excess(own.distance, own.action.speed, other.distance, other.speed);
        for piece in &own_path.pieces[..own_path.count] {
            if piece.stands {
                continue;
            }
            let mut start = usize::from(piece.from == 0);
            while start < piece.samples {
                let end = (start + BLOCK).min(piece.samples);
                let first = sight.at(piece, other_path, start);
                let last = sight.at(piece, other_path, end - 1);
                if first.is_past() {
                    return Some(sum);
                }
                if !piece.is_even || Edges::may_collide(&first, &last) {
                    let from = piece.from + start;
                    sum += self.weight(from) * self.block(&sight, piece, other_path, start, end)?;
                }
                start = end;
            }
        }
        Some(sum)
    }

    /// Σ of the excess over samples of one piece, discounted from its start. `None` where rounding decides.
    #[inline]
    fn block(
        &self,
        sight: &Sight,
        piece: &Piece,
        other: &OtherPath,
        start: usize,
        end: usize,
    ) -> Option<f64> {
        let weights = self.first_weights();
        let mut sums = [0.0; LANES];
        for group in (start..end).step_by(LANES) {
            let (mut own, mut others) = ([(0.0, 0.0); LANES], [(0.0, 0.0); LANES]);
            let mut counts = [0.0; LANES];
            let mut at_edge = false;
            for l in 0..LANES {
                let n = (group + l) as f64;
                own[l] = piece.at(n);
                others[l] = other.at(n + piece.first);
                let collides = sight.collides_moving(own[l], others[l]) & (group + l < end);
                counts[l] = if collides { weights[group - start + l] } else { 0.0 };
                at_edge |= sight.ends_by_rounding(own[l].0, others[l].0) & (group + l < end);
            }
            if at_edge {
                return None;
            }
            if counts != [0.0; LANES] {
                for l in 0..LANES {
                    sums[l] += counts[l] * sight.excess_on_course(own[l], others[l]);
                }
            }
        }
        Some(sums.iter().sum())
    }

    /// Σ of the discounted excess with the published running sums: their last bit decides where someone stands at
    /// the edge of the conflict space.
    #[cold]
    fn sample_by_sample(&self, cost: &LoomingCost, own: &OwnTrack, other: &OtherTrack) -> f64 {
        let sight = Sight::new(cost, own, other);
        let phases = own.phases;
        let samples = phases.end() + usize::from(phases.left_over);
        let starts = &phases.starts;
        let (mut d, mut u) = (own.distance, own.action.speed);
        let (mut e, mut w_sum) = (other.distance, other.speed);
        let mut regain = 0.0;
        let mut sum = 0.0;
        for n in 0..samples {
            if phases.integrated == 4 && n == starts[1] {
                if phases.stands_while_waiting() {
                    u = 0.0;
                }
                regain = (own.free_speed - u) / own.regain_time;
            }
            let a = if n < starts[0] {
                own.action.acceleration + own.action.jerk * (n as f64 * SAMPLE_TIME)
            } else if phases.integrated >= 2 && n < starts[1] {
                own.achieve
            } else if phases.integrated == 4 && (starts[2]..starts[3]).contains(&n) {
                regain
            } else {
                0.0
            };
            let w = if w_sum > 0.0 { w_sum } else { 0.0 };
            sum += self.weight(n) * sight.excess(d, u, e, w);
            d = d - u * SAMPLE_TIME - a * (SAMPLE_TIME * SAMPLE_TIME) / 2.0;
            u += SAMPLE_TIME * a;
            e -= w * SAMPLE_TIME;
            w_sum += SAMPLE_TIME * if n == 0 { other.first_acceleration } else { other.later_acceleration };
        }
        sum
    }
}

/// A piece of one's own path in closed form: distance and speed are polynomials of the sample in it.
#[derive(Clone, Copy, Debug, Default)]
struct Piece {
    /// First sample.
    from: usize,
    /// The same as a number.
    first: f64,
    samples: usize,
    distance: f64,
    travelled: [f64; 3],
    speed: [f64; 3],
    /// Whether it is at exactly zero speed outside the conflict space, where nothing looms.
    stands: bool,
    /// Whether the acceleration is constant, so that speeds lie between those of the ends.
    is_even: bool,
}

impl Piece {
    /// From sample `from`, where distance and speed are these, with this acceleration and jerk (per second).
    fn new(from: usize, samples: usize, d: f64, u: f64, acceleration: f64, jerk: f64) -> Self {
        let t = SAMPLE_TIME;
        let j = jerk * t;
        let c = j * t / 2.0;
        let b = t * acceleration - c;
        Self {
            from,
            first: from as f64,
            samples,
            distance: d,
            travelled: [
                t * (u - b / 2.0 + c / 6.0) + t * t / 2.0 * (acceleration - j / 2.0),
                t * (b / 2.0 - c / 2.0) + t * t * j / 4.0,
                t * c / 3.0,
            ],
            speed: [u, b, c],
            stands: false,
            is_even: jerk == 0.0,
        }
    }

    /// Distance and speed at sample `n` of the piece.
    #[inline(always)]
    fn at(&self, n: f64) -> (f64, f64) {
        let [k1, k2, k3] = self.travelled;
        let [u, b, c] = self.speed;
        (self.distance - n * (k1 + n * (k2 + n * k3)), u + n * (b + n * c))
    }

    /// The lowest speed at its samples.
    fn lowest_speed(&self) -> f64 {
        let [u, b, c] = self.speed;
        let last = (self.samples - 1) as f64;
        let turn = if c > 0.0 { (-b / (2.0 * c)).clamp(0.0, last) } else { 0.0 };
        u.min(self.at(last).1).min(self.at(turn).1)
    }
}

/// One's own path as pieces, in order.
struct OwnPath {
    pieces: [Piece; 5],
    count: usize,
}

impl OwnPath {
    /// `None` where someone goes backwards, or stands where rounding decides.
    #[inline]
    fn new(own: &OwnTrack) -> Option<Self> {
        let phases = own.phases;
        let starts = &phases.starts;
        let mut path = Self { pieces: [Piece::default(); 5], count: 0 };
        let (mut d, mut u) = (own.distance, own.action.speed);
        let stands = phases.stands_while_waiting();
        let half_extent = own.body.half_extent;
        // A speed that comes out as 0 here may be a little off 0 in the published sums, unless nothing was summed.
        let mut exact = true;
        let mut add = |from: usize, to: usize, d: &mut f64, u: &mut f64, acceleration: f64, jerk: f64| {
            if from == to {
                return true;
            }
            let mut piece = Piece::new(from, to - from, *d, *u, acceleration, jerk);
            let is_still = *u == 0.0 && acceleration == 0.0 && jerk == 0.0;
            let (last_distance, last_speed) = piece.at((piece.samples - 1) as f64);
            let starts_exactly = exact || (stands && from == starts[1]);
            exact = starts_exactly && is_still;
            if piece.lowest_speed() < -STANDSTILL
                || is_rounding(*d, *u, half_extent, starts_exactly)
                || is_rounding(last_distance, last_speed, half_extent, exact)
            {
                return false;
            }
            piece.stands = is_still && d.abs() > half_extent;
            (*d, *u) = piece.at(piece.samples as f64);
            path.pieces[path.count] = piece;
            path.count += 1;
            true
        };
        let mut whole = add(0, starts[0], &mut d, &mut u, own.action.acceleration, own.action.jerk);
        if phases.integrated >= 2 {
            whole &= add(starts[0], starts[1], &mut d, &mut u, own.achieve, 0.0);
        }
        if stands {
            u = 0.0;
        }
        let regain = (own.free_speed - u) / own.regain_time;
        if phases.integrated >= 3 {
            whole &= add(starts[1], starts[2], &mut d, &mut u, 0.0, 0.0);
        }
        if phases.integrated == 4 {
            whole &= add(starts[2], starts[3], &mut d, &mut u, regain, 0.0);
        }
        if phases.left_over {
            whole &= add(phases.end(), phases.end() + 1, &mut d, &mut u, 0.0, 0.0);
        }
        whole.then_some(path)
    }
}

/// Whether it is a matter of rounding on which side of the edge of the conflict space someone stands, or whether
/// someone inside stands or moves. `exact`: a speed of 0 is 0 in the published sums too.
fn is_rounding(distance: f64, speed: f64, half_extent: f64, exact: bool) -> bool {
    let edge = distance.abs() - half_extent;
    speed < STANDSTILL && edge < EDGE && !(exact && speed == 0.0 && edge < -EDGE)
}

/// The other's path from the second sample on, in closed form: it may come to stand.
struct OtherPath {
    distance: f64,
    speed: f64,
    /// Speed change per sample.
    change: f64,
    /// The sample, counted from the second, from which on it stands.
    stands_from: f64,
}

impl OtherPath {
    /// `None` where it stands where rounding decides, or starts again from a standstill.
    #[inline]
    fn new(other: &OtherTrack) -> Option<Self> {
        let distance = other.distance - other.speed * SAMPLE_TIME;
        let speed = other.speed + SAMPLE_TIME * other.first_acceleration;
        let change = SAMPLE_TIME * other.later_acceleration;
        let stands_from = if change < 0.0 {
            (speed / -change).ceil().max(0.0)
        } else if speed <= 0.0 {
            if change > 0.0 {
                return None;
            }
            0.0
        } else {
            f64::INFINITY
        };
        let path = Self { distance, speed, change, stands_from };
        let half_extent = other.body.half_extent;
        let at_edge = is_rounding(other.distance, other.speed, half_extent, true)
            || (stands_from < f64::INFINITY
                && is_rounding(path.at(stands_from + 1.0).0, 0.0, half_extent, true));
        (!at_edge).then_some(path)
    }

    /// Distance and speed at sample `n` of the future, from 1.
    #[inline(always)]
    fn at(&self, n: f64) -> (f64, f64) {
        let m = n - 1.0;
        let moving = if m < self.stands_from { m } else { self.stands_from };
        let w = self.speed + self.change * m;
        (
            self.distance - SAMPLE_TIME * moving * (self.speed + self.change * (moving - 1.0) / 2.0),
            if w > 0.0 { w } else { 0.0 },
        )
    }
}

/// What decides how something looms: the extents of the two, and what is seen of the other.
struct Sight {
    own_half_extent: f64,
    other_half_extent: f64,
    width: f64,
    quarter_square: f64,
    cosine: f64,
    onset: f64,
}

impl Sight {
    fn new(cost: &LoomingCost, own: &OwnTrack, other: &OtherTrack) -> Self {
        let width = other.body.width;
        Self {
            own_half_extent: own.body.half_extent,
            other_half_extent: other.body.half_extent,
            width,
            quarter_square: width * width / 4.0,
            cosine: other.body.cosine,
            onset: cost.onset,
        }
    }

    /// How far the optical expansion rate is above the onset; 0 off a collision course. Times are IEEE divisions.
    fn excess(&self, d: f64, u: f64, e: f64, w: f64) -> f64 {
        let own_entry = (d - self.own_half_extent) / u;
        let own_exit = (d + self.own_half_extent) / u;
        let other_entry = (e - self.other_half_extent) / w;
        let other_exit = (e + self.other_half_extent) / w;
        let collides = (own_entry < other_entry && other_entry < own_exit && other_entry > 0.0)
            || (other_entry < own_entry && own_entry < other_exit && own_entry > 0.0)
            || (own_entry == other_entry && own_entry > 0.0);
        if collides { self.excess_on_course((d, u), (e, w)) } else { 0.0 }
    }

    /// Whether two with these distances and speeds are on a collision course: the times of [`Self::excess`] multiplied
    /// by both speeds.
    #[inline(always)]
    fn collides_moving(&self, (d, u): (f64, f64), (e, w): (f64, f64)) -> bool {
        let own_entry = (d - self.own_half_extent) * w;
        let own_exit = (d + self.own_half_extent) * w;
        let other_entry = (e - self.other_half_extent) * u;
        let other_exit = (e + self.other_half_extent) * u;
        let later_entry = if own_entry > other_entry { own_entry } else { other_entry };
        let earlier_exit = if own_exit < other_exit { own_exit } else { other_exit };
        let meet = (later_entry > 0.0) & (later_entry < earlier_exit);
        // Who stands inside is there from ever to ever: the other only has to be still on its way.
        let own_stands = (u == 0.0) & (d.abs() < self.own_half_extent);
        let other_stands = (w == 0.0) & (e.abs() < self.other_half_extent);
        meet | (own_stands & (w > 0.0) & (e > self.other_half_extent))
            | (other_stands & (u > 0.0) & (d > self.own_half_extent))
    }

    /// Whether the later of the two is just at the edge of the conflict space, where a collision course ends.
    #[inline(always)]
    fn ends_by_rounding(&self, d: f64, e: f64) -> bool {
        let (own_front, other_front) = (d - self.own_half_extent, e - self.other_half_extent);
        let later_front = if own_front > other_front { own_front } else { other_front };
        later_front.abs() < EDGE
    }

    /// How far the optical expansion rate of the other is above the onset, with the distances and speeds of the two.
    #[inline(always)]
    fn excess_on_course(&self, (d, u): (f64, f64), (e, w): (f64, f64)) -> f64 {
        let (range_squared, closing) = if self.cosine == 0.0 {
            (d * d + e * e, d * u + e * w)
        } else {
            // By the law of cosines; at a right angle the published expressions, whose bits decide.
            let cosine = self.cosine;
            (d * d + e * e - 2.0 * d * e * cosine, d * u + e * w - (u * e + d * w) * cosine)
        };
        let rate = self.width * closing / (range_squared.sqrt() * (range_squared + self.quarter_square));
        let excess = rate - self.onset;
        if excess > 0.0 { excess } else { 0.0 }
    }

    /// Where the edges of the two are at a sample of a piece.
    #[inline]
    fn at(&self, piece: &Piece, other: &OtherPath, n: usize) -> Edges {
        let (d, u) = piece.at(n as f64);
        let (e, w) = other.at(n as f64 + piece.first);
        Edges {
            own_front: d - self.own_half_extent,
            own_rear: d + self.own_half_extent,
            own_speed: u,
            other_front: e - self.other_half_extent,
            other_rear: e + self.other_half_extent,
            other_speed: w,
        }
    }
}

/// Distances of the fronts and rears to the conflict space, and the speeds, at one sample.
struct Edges {
    own_front: f64,
    own_rear: f64,
    own_speed: f64,
    other_front: f64,
    other_rear: f64,
    other_speed: f64,
}

impl Edges {
    /// Whether one of the two is out of the conflict space, so that nothing looms any more.
    fn is_past(&self) -> bool {
        self.own_rear <= 0.0 || self.other_rear <= 0.0
    }

    /// Whether the two may be on a collision course at some sample between two: unless one of them enters after the
    /// other has left, even with the fastest approach of the one and the slowest of the other.
    fn may_collide(first: &Self, last: &Self) -> bool {
        let own_slowest = first.own_speed.min(last.own_speed);
        let own_fastest = first.own_speed.max(last.own_speed);
        let other_slowest = first.other_speed.min(last.other_speed);
        let other_fastest = first.other_speed.max(last.other_speed);
        let own_later =
            last.own_front > 0.0 && last.own_front * other_slowest > first.other_rear * own_fastest;
        let other_later =
            last.other_front > 0.0 && last.other_front * own_slowest > first.own_rear * other_fastest;
        !(own_later || other_later)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::super::access::{AccessCourse, Manner};
    use super::super::sampled;
    use super::super::state::Control;
    use super::super::value::Gains;
    use super::*;

    const PEDESTRIAN: AgentBody =
        AgentBody { control: Control::Speed, half_extent: 1.3, cosine: 0.0, width: 0.8 };
    const VEHICLE: AgentBody =
        AgentBody { control: Control::Acceleration, half_extent: 2.5, cosine: 0.0, width: 1.8 };

    prop_compose! {
        fn a_course()(
            acceleration in -5.0..5.0,
            duration in prop_oneof![Just(0.0), 0.0..20.0, Just(f64::INFINITY)],
            wait in prop_oneof![2 => Just(0.0), 2 => 0.0..100.0, 1 => Just(f64::INFINITY)],
        ) -> AccessCourse {
            AccessCourse { acceleration, duration, wait }
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]
        #[test]
        fn looming_is_the_sampled_sum(
            half_life in 5.0..100.0f64,
            onset in prop_oneof![Just(0.0), 0.0..0.1],
            is_vehicle: bool,
            (distance, other_distance) in (-8.0..80.0, -8.0..80.0),
            speed in prop_oneof![Just(0.0), 0.0..15.0],
            other_speed in prop_oneof![Just(0.0), 0.0..15.0],
            (acceleration, jerk) in (-5.0..5.0, -4.0..4.0),
            first_acceleration in prop_oneof![Just(0.0), -4.0..4.0],
            later_acceleration in prop_oneof![Just(0.0), -4.0..4.0],
            course in a_course(),
            stops in prop_oneof![3 => Just(false), 1 => Just(true)],
            cosine in prop_oneof![1 => Just(0.0), 2 => -0.94..0.94],
        ) {
            // Someone who stops just at the end of the action stands where rounding decides.
            let (speed, acceleration, jerk) =
                if stops { (f64::round(2.0 * speed) / 2.0, -f64::round(2.0 * speed), 0.0) } else { (speed, acceleration, jerk) };
            let [body, other_body] = if is_vehicle { [VEHICLE, PEDESTRIAN] } else { [PEDESTRIAN, VEHICLE] }
                .map(|body| AgentBody { cosine, ..body });
            let free_speed = if is_vehicle { 50.0 / 3.6 } else { 1.3 };
            let gains = Gains::for_free_speed(free_speed, 0.5);
            let regain_time = Manner::regain_time(body.control, 0.5);
            let cost = LoomingCost { onset, full: onset + 0.01 };
            let action = ActionPhase { speed, acceleration, jerk: if is_vehicle { jerk } else { 0.0 } };
            let other = OtherTrack {
                distance: other_distance,
                speed: other_speed,
                body: &other_body,
                first_acceleration,
                later_acceleration,
            };
            let samples = sampled::future(half_life, 0.5, &gains, &action, &course, regain_time);
            let expected = sampled::looming(&samples, &cost, distance, &body, &other);
            let discounting = Discounting::new(half_life, 0.5);
            let phases = discounting.phases(&course, regain_time);
            let own = OwnTrack {
                distance,
                body: &body,
                action: &action,
                achieve: course.acceleration,
                phases: &phases,
                free_speed: gains.free_speed(),
                regain_time,
            };
            let found = discounting.looming(&cost, &own, &other);
            prop_assert!((found - expected).abs() <= 1e-9 * expected.abs().max(1.0), "{found} is not {expected}");
            // Nothing jumps beside a right angle.
            let of_cosine = |cosine| {
                let body = AgentBody { cosine, ..other_body };
                discounting.looming(&cost, &own, &OtherTrack { body: &body, ..other })
            };
            let (right, nearly) = (of_cosine(0.0), of_cosine(libm::cos(f64::to_radians(89.999))));
            prop_assert!((right - nearly).abs() <= 1e-3 * right.abs().max(1.0), "{nearly} is not {right}");
        }
    }
}
