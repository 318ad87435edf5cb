//! Keeps people from walking through boxes and each other, whatever their models want.
//!
//! Between two bodies lies a line, and each stays on its side of it: in the middle between two people, at the face of a box. A step that would
//! lead over it is shortened across it and goes on along it. People evade each other to the right where they meet head on; behind a person
//! that walks the same way the step is shortened only. Around a box a person goes on the side on which its end is nearer, at their own pace,
//! and their model decides as if they walked straight on. Where no such step is found, the person stands. The lines are those of the beginning
//! of the step, so that the order of the people does not matter.

use nalgebra::Vector2;

use super::geometry::{Footprint, apart};
use scenario::agent::{Motion, PedestrianState};
use scenario::{Shape, World};

/// What is always left between people and what they keep clear of, m.
const GAP: f64 = 1e-6;

/// A step is bent so often at most before they stand.
const MOST_BENDS: usize = 8;

/// Sine of the angle within which two meet head on.
const HEAD_ON: f64 = 0.2;

/// As much of a step may lead over a line by rounding, m.
const ROUNDING: f64 = 1e-12;

/// The people of a world that keep clear, and the boxes.
pub(super) struct KeepClear {
    /// The gap that each person keeps, m; `None` of a person that does not keep clear.
    gaps: Vec<Option<f64>>,
    boxes: Vec<Footprint>,
    /// Where each person would be after the step that their model wants; `None` of a person that is not on the road.
    wanted: Vec<Option<PedestrianState>>,
    /// What the model of each person that steps around a box sees instead.
    detours: Vec<Option<Detour>>,
    /// On which side each of them goes around each box while near it, one person after the other.
    sides: Vec<Option<Side>>,
    /// The lines of the present walker.
    lines: Vec<Line>,
}

/// The side on which a box is passed, seen by the person that walks towards it.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Side {
    Left,
    Right,
}

impl Side {
    fn sign(self) -> f64 {
        match self {
            Self::Left => -1.0,
            Self::Right => 1.0,
        }
    }
}

/// A person that steps around a box, as their model sees them.
#[derive(Debug, Clone, Copy)]
struct Detour {
    /// Which way they would walk, a unit vector.
    heading: Vector2<f64>,
    /// How fast, m/s.
    pace: f64,
    /// How that changed over the last step, m/s².
    acceleration: f64,
    side: Side,
    /// Whether the box was in the way in the last step; after it the model is shown once more what it had asked for.
    is_blocked: bool,
}

/// What a walker must not cross.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Line {
    /// Unit vector over it.
    normal: Vector2<f64>,
    /// How far the walker may go along `normal`, m.
    room: f64,
    /// Whether the two are apart, so that no corner may be turned over it either.
    apart: bool,
    of: Of,
    /// Whether it has bent the step.
    has_bent: bool,
}

/// What is on the other side of a line.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Of {
    /// A person that walks with this velocity, m/s.
    Person(Vector2<f64>),
    Box {
        index: usize,
        side: Side,
    },
}

impl KeepClear {
    /// `None` where there is nothing to keep clear of, or no person does.
    pub fn new(world: &World) -> Option<Self> {
        let gaps: Vec<_> = world.pedestrians.iter().map(scenario::PedestrianSetup::keeps_clear).collect();
        let boxes: Vec<Footprint> = world.road.boxes.iter().map(Footprint::from).collect();
        let bodies = gaps.len().saturating_sub(1) + boxes.len();
        (gaps.iter().any(Option::is_some) && bodies > 0).then(|| Self::of(gaps, boxes))
    }

    fn of(gaps: Vec<Option<f64>>, boxes: Vec<Footprint>) -> Self {
        Self {
            wanted: vec![None; gaps.len()],
            detours: vec![None; gaps.len()],
            sides: vec![None; gaps.len() * boxes.len()],
            lines: Vec::with_capacity(gaps.len().saturating_sub(1) + 2 * boxes.len()),
            gaps,
            boxes,
        }
    }

    /// How the model of a person that steps around a box sees them: as they would walk without it. `None` of other people.
    pub fn shown(&self, index: usize, now: &PedestrianState) -> Option<PedestrianState> {
        let detour = self.detours[index].as_ref()?;
        // Something else may have kept them from walking.
        let pace = if now.velocity.norm() == 0.0 { 0.0 } else { detour.pace };
        Some(PedestrianState {
            heading: detour.heading,
            velocity: detour.heading * pace,
            acceleration: detour.heading * detour.acceleration,
            ..*now
        })
    }

    /// Bends the motions that would not keep clear. `walk` moves a person by the whole of a step of `step` s.
    pub fn bend(
        &mut self,
        people: &[PedestrianState],
        motions: &mut [Motion],
        step: f64,
        walk: impl Fn(usize, &mut PedestrianState, Motion),
    ) {
        for (index, now) in people.iter().enumerate() {
            let wanted = now.present.then(|| {
                let mut then = self.shown(index, now).unwrap_or(*now);
                walk(index, &mut then, motions[index]);
                then
            });
            self.wanted[index] = wanted;
        }
        let ways = self.wanted.iter().flatten().zip(people.iter().filter(|one| one.present));
        let longest = ways.map(|(then, now)| (then.position - now.position).norm()).fold(0.0, f64::max);
        for index in 0..people.len() {
            let (Some(wanted), Some(gap)) = (self.wanted[index], self.gaps[index]) else { continue };
            let detour = self.detours[index];
            let (now, then) = (Footprint::from(&people[index]), Footprint::from(&wanted));
            if now == then || detour.is_some() && now.centre == then.centre {
                if let Some(detour) = &mut self.detours[index] {
                    (detour.pace, detour.acceleration) = (0.0, 0.0);
                    motions[index] = Motion::Walk(Vector2::zeros());
                }
                continue;
            }
            self.find_lines(index, people, (longest, gap), then.centre - now.centre);
            let bent = bent(&mut self.lines, &now, &then);
            let side = self.remember_sides(index);
            if let Some(way) = bent {
                motions[index] = Motion::Walk(way / step);
            }
            let stands = bent.is_some_and(|way| way == Vector2::zeros());
            let pace = if stands { 0.0 } else { wanted.velocity.norm() };
            let before = detour.map_or(people[index].velocity.norm(), |detour| detour.pace);
            let acceleration = (pace - before) / step;
            let heading = wanted.heading;
            self.detours[index] = match (side, detour) {
                (Some(side), _) => Some(Detour { heading, pace, acceleration, side, is_blocked: true }),
                (None, Some(before)) if before.is_blocked => {
                    // The first step past the box: as the model wanted it that saw the person walk on.
                    if bent.is_none() {
                        motions[index] = Motion::Walk((then.centre - now.centre) / step);
                    }
                    Some(Detour { heading, pace, acceleration, is_blocked: false, ..before })
                }
                (None, _) => None,
            };
        }
    }

    /// The lines of a person that wants to go `way` (m) and keeps `gap` m, where no person goes farther than `longest` m.
    fn find_lines(
        &mut self,
        index: usize,
        people: &[PedestrianState],
        (longest, gap): (f64, f64),
        way: Vector2<f64>,
    ) {
        let now = Footprint::from(&people[index]);
        let inherited = self.detours[index].map(|detour| detour.side);
        self.lines.clear();
        // The body must have room to turn before the box.
        let round = Footprint { shape: Shape::Disc { radius: now.radius() }, ..now };
        let sides = self.sides[index * self.boxes.len()..].iter_mut();
        for (number, (body, known)) in self.boxes.iter().zip(sides).enumerate() {
            let Some((normal, between)) = line(&round, body, (longest, gap)) else {
                *known = None;
                continue;
            };
            let side = known.or(inherited).unwrap_or_else(|| {
                let width = 2.0 * (now.radius() + gap + GAP);
                nearer_end(&now, &row(&self.boxes, number, width), normal, way)
            });
            let of = Of::Box { index: number, side };
            self.lines.push(Line { apart: false, ..Line::new((normal, between), gap, of) });
            // A body that is nearer already may go on, but comes no nearer.
            let nearer =
                line(&now, body, (longest, gap)).filter(|_| between <= 0.0 && now.shape != round.shape);
            self.lines.extend(nearer.map(|found| Line::new(found, gap, of)));
        }
        let others = people.iter().enumerate().filter(|(other, state)| *other != index && state.present);
        for (_, other) in others {
            let found = line(&now, &Footprint::from(other), (longest, gap));
            self.lines.extend(found.map(|found| Line::new(found, gap, Of::Person(other.velocity))));
        }
    }

    /// Keeps the sides of the boxes that have bent a step; that of the last one, if there is any.
    fn remember_sides(&mut self, index: usize) -> Option<Side> {
        let mut last = None;
        for line in self.lines.iter().filter(|line| line.has_bent) {
            if let Of::Box { index: number, side, .. } = line.of {
                self.sides[index * self.boxes.len() + number] = Some(side);
                last = Some(side);
            }
        }
        last
    }
}

/// The box of that number with all that are passed together with it: no gap between them is `width` m wide.
fn row(boxes: &[Footprint], number: usize, width: f64) -> Vec<&Footprint> {
    let mut others: Vec<&Footprint> = boxes.iter().collect();
    let mut row = vec![others.swap_remove(number)];
    let mut looked_at = 0;
    while let Some(body) = row.get(looked_at).copied() {
        row.extend(others.extract_if(.., |other| apart(body, other) < width));
        looked_at += 1;
    }
    row
}

/// The side on which a person that wants to go `way` (m) passes a row of boxes: of one box where the way leads along its face, else where the
/// end of the row is nearer; the right if both are as near.
fn nearer_end(walker: &Footprint, row: &[&Footprint], normal: Vector2<f64>, way: Vector2<f64>) -> Side {
    let is_left = match row {
        [body] => {
            let right = right_of(normal);
            let along = way.dot(&right);
            match along.abs() > HEAD_ON * way.norm() {
                true => along < 0.0,
                false => (body.centre - walker.centre).dot(&right) > 0.0,
            }
        }
        // The nearest corner says nothing of where a row ends.
        row => {
            let right = right_of(way.try_normalize(0.0).unwrap_or(normal));
            let place = |body: &&Footprint| (body.centre - walker.centre).dot(&right);
            let ends =
                row.iter().map(|body| (place(body) - body.reach(right), place(body) + body.reach(right)));
            let (left, end) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(left, end), (from, to)| {
                (left.min(from), end.max(to))
            });
            left + end > GAP
        }
    };
    if is_left { Side::Left } else { Side::Right }
}

/// To the right of a unit vector.
fn right_of(normal: Vector2<f64>) -> Vector2<f64> {
    Vector2::new(normal.y, -normal.x)
}

/// The direction of the line between a walker and a body, and what lies between them along it, m; none if no person gets that far by ways of at
/// most `longest` m.
fn line(walker: &Footprint, body: &Footprint, (longest, gap): (f64, f64)) -> Option<(Vector2<f64>, f64)> {
    let offset = body.centre - walker.centre;
    if offset.norm() > walker.radius() + body.radius() + gap + GAP + 2.0 * longest {
        return None;
    }
    let (mut best, mut normal) = (f64::NEG_INFINITY, Vector2::<f64>::zeros());
    let mut try_one = |axis: Vector2<f64>| {
        let axis = if offset.dot(&axis) < 0.0 { -axis } else { axis };
        let between = offset.dot(&axis) - (walker.reach(axis) + body.reach(axis));
        // The same for both of them: also where two are equally far apart along several.
        let order = between.total_cmp(&best).then(axis.x.abs().total_cmp(&normal.x.abs()));
        if order.then((axis.x * axis.y).total_cmp(&(normal.x * normal.y))).is_gt() {
            (best, normal) = (between, axis);
        }
    };
    for one in [walker, body] {
        if matches!(one.shape, Shape::Rectangle { .. }) {
            try_one(one.heading);
            try_one(one.across());
        }
    }
    let nearest = match (walker.shape, body.shape) {
        (Shape::Disc { .. }, Shape::Disc { .. }) => Some(offset),
        (Shape::Rectangle { .. }, Shape::Disc { .. }) => Some(walker.nearest_to(body.centre)),
        (Shape::Disc { .. }, Shape::Rectangle { .. }) => Some(-body.nearest_to(walker.centre)),
        _ => None,
    };
    // Two in the same place have no line between them and part as their models want.
    if let Some(axis) = nearest.and_then(|way| way.try_normalize(0.0)) {
        try_one(axis);
    }
    (best > f64::NEG_INFINITY).then_some((normal, best))
}

impl Line {
    /// A line of this direction where so much lies between two bodies, m. People use half of it each, but for `gap` m.
    fn new((normal, between): (Vector2<f64>, f64), gap: f64, of: Of) -> Self {
        let share = if matches!(of, Of::Person(_)) { 0.5 } else { 1.0 };
        let room = ((between - GAP - gap) * share).max(0.0);
        Self { normal, room, apart: between > 0.0, of, has_bent: false }
    }

    /// How far a step leads over it, m; negative if it does not.
    fn crossed_by(&self, now: &Footprint, heading: Vector2<f64>, way: Vector2<f64>) -> f64 {
        let turned = Footprint { heading, ..*now };
        let turn = if self.apart { turned.reach(self.normal) - now.reach(self.normal) } else { 0.0 };
        way.dot(&self.normal) + turn - self.room
    }

    /// The step that is walked instead of `way`, which leads `much` over it, by a person that wants to go `wanted`, m.
    fn bend(&self, way: Vector2<f64>, much: f64, wanted: Vector2<f64>) -> Vector2<f64> {
        let (shortened, right, length) = (way - self.normal * much, right_of(self.normal), wanted.norm());
        let way = match self.of {
            Of::Person(velocity) if velocity.dot(&wanted) > 0.0 => shortened,
            Of::Person(_) if wanted.dot(&right) < -HEAD_ON * length => shortened - right * much,
            Of::Person(_) => shortened + right * much,
            // Along a box the side stays the same, wherever the goal is.
            Of::Box { side, .. } => {
                let across = shortened.dot(&self.normal);
                let along = (length * length - across * across).max(0.0).sqrt();
                self.normal * across + right * (side.sign() * along)
            }
        };
        let longer = way.norm();
        if longer > length { way * (length / longer) } else { way }
    }
}

/// The way (m) that is walked instead of the wanted one; none if that crosses no line.
fn bent(lines: &mut [Line], now: &Footprint, then: &Footprint) -> Option<Vector2<f64>> {
    let wanted = then.centre - now.centre;
    let mut way = wanted;
    for _ in 0..MOST_BENDS {
        let heading =
            if way == wanted { then.heading } else { way.try_normalize(1e-9).unwrap_or(now.heading) };
        let over = |line: &Line| line.crossed_by(now, heading, way);
        // Of those that are crossed the one that is most, in whatever order they come.
        let worst = lines.iter_mut().max_by(|one, other| {
            let by_way =
                one.normal.x.total_cmp(&other.normal.x).then(one.normal.y.total_cmp(&other.normal.y));
            over(one).total_cmp(&over(other)).then(by_way)
        });
        let Some(line) = worst.filter(|line| over(line) > ROUNDING) else {
            return (way != wanted).then_some(way);
        };
        line.has_bent = true;
        way = line.bend(way, over(line), wanted);
    }
    Some(Vector2::zeros())
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::geometry::apart;

    const STEP: f64 = 0.1;

    /// A person with this shape at a place that always walks towards another place at this speed (m/s).
    #[derive(Debug, Clone)]
    struct Walker {
        state: PedestrianState,
        goal: Vector2<f64>,
        speed: f64,
    }

    impl Walker {
        fn new(shape: Shape, from: (f64, f64), to: (f64, f64), speed: f64) -> Self {
            let (position, goal) = (Vector2::new(from.0, from.1), Vector2::new(to.0, to.1));
            let heading = (goal - position).try_normalize(0.0).unwrap_or_else(Vector2::x);
            let still = Vector2::zeros();
            let state = PedestrianState {
                position,
                velocity: still,
                acceleration: still,
                heading,
                shape,
                present: true,
            };
            Self { state, goal, speed }
        }
    }

    fn walk(state: &mut PedestrianState, motion: Motion) {
        let Motion::Walk(velocity) = motion else { unreachable!("they walk") };
        state.position += velocity * STEP;
        state.velocity = velocity;
        state.heading = velocity.try_normalize(1e-6).unwrap_or(state.heading);
    }

    /// Where they are after each step.
    fn run(walkers: &[Walker], boxes: &[Footprint], steps: usize) -> Vec<Vec<PedestrianState>> {
        let mut rule = KeepClear::of(vec![Some(0.0); walkers.len()], boxes.to_vec());
        let mut now: Vec<_> = walkers.iter().map(|walker| walker.state).collect();
        let step = |_| {
            let wanted = now.iter().zip(walkers).map(|(state, walker)| {
                let way = walker.goal - state.position;
                Motion::Walk(way.cap_magnitude(walker.speed * STEP) / STEP)
            });
            let mut motions: Vec<_> = wanted.collect();
            rule.bend(&now, &mut motions, STEP, |_, state, motion| walk(state, motion));
            now.iter_mut().zip(&motions).for_each(|(state, motion)| walk(state, *motion));
            now.clone()
        };
        (0..steps).map(step).collect()
    }

    fn nearest(states: &[PedestrianState], boxes: &[Footprint]) -> f64 {
        let people: Vec<_> = states.iter().map(Footprint::from).collect();
        let between = people.iter().enumerate().flat_map(|(index, one)| {
            people[index + 1..].iter().chain(boxes).map(move |other| apart(one, other))
        });
        between.fold(f64::INFINITY, f64::min)
    }

    fn shape() -> impl Strategy<Value = Shape> {
        prop_oneof![
            (0.15..0.4).prop_map(|radius| Shape::Disc { radius }),
            (0.2..0.6, 0.3..0.8).prop_map(|(length, width)| Shape::Rectangle { length, width }),
        ]
    }

    fn place() -> impl Strategy<Value = (f64, f64)> {
        (-4.0..4.0, -4.0..4.0)
    }

    fn crowd() -> impl Strategy<Value = Vec<Walker>> {
        let walker = (shape(), place(), place(), 0.0..3.0);
        let walker = walker.prop_map(|(shape, from, to, speed)| Walker::new(shape, from, to, speed));
        prop::collection::vec(walker, 1..7)
    }

    fn obstacles() -> impl Strategy<Value = Vec<Footprint>> {
        let one = (place(), 0.5..5.0, 0.5..2.0, 0.0..6.3).prop_map(|(at, length, width, angle)| Footprint {
            centre: Vector2::new(at.0, at.1),
            heading: Vector2::new(libm::cos(angle), libm::sin(angle)),
            shape: Shape::Rectangle { length, width },
        });
        prop::collection::vec(one, 0..3)
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        #[test]
        fn people_walk_into_nothing(crowd in crowd(), boxes in obstacles()) {
            let start: Vec<_> = crowd.iter().map(|walker| walker.state).collect();
            prop_assume!(nearest(&start, &boxes) > 0.0);
            for states in run(&crowd, &boxes, 150) {
                prop_assert!(nearest(&states, &boxes) > 0.0, "{states:?}");
            }
        }

        #[test]
        fn the_order_of_people_changes_nothing(
            (crowd, order) in crowd().prop_flat_map(|crowd| {
                let order: Vec<_> = (0..crowd.len()).collect();
                (Just(crowd), Just(order).prop_shuffle())
            }),
            boxes in obstacles(),
        ) {
            let other: Vec<_> = order.iter().map(|index| crowd[*index].clone()).collect();
            for (one, other) in run(&crowd, &boxes, 100).iter().zip(run(&other, &boxes, 100)) {
                for (place, index) in order.iter().enumerate() {
                    prop_assert_eq!(&one[*index], &other[place]);
                }
            }
        }

        #[test]
        fn people_that_meet_no_other_walk_as_alone(one in place(), far in 30.0..50.0) {
            let disc = Shape::Disc { radius: 0.25 };
            let walker = Walker::new(disc, one, (-one.0, -one.1), 1.4);
            let other = Walker::new(disc, (far, far), (far + 5.0, far), 2.0);
            let together = run(&[walker.clone(), other], &[], 100);
            let alone = run(&[walker], &[], 100);
            for (together, alone) in together.iter().zip(&alone) {
                prop_assert_eq!(&together[0], &alone[0]);
            }
        }
    }

    /// Face to face both pass, each on the right of their way, and get where they want to.
    #[test]
    fn two_who_meet_evade_to_their_right() {
        let disc = Shape::Disc { radius: 0.25 };
        let crowd = [
            Walker::new(disc, (0.0, -3.0), (0.0, 3.0), 1.4),
            Walker::new(disc, (0.0, 3.0), (0.0, -3.0), 1.2),
        ];
        let all = run(&crowd, &[], 100);
        let last = all.last().unwrap();
        for (state, walker) in last.iter().zip(&crowd) {
            assert!((state.position - walker.goal).norm() < 1e-9, "{state:?}");
        }
        let passing = all.iter().find(|states| states[0].position.y >= states[1].position.y).unwrap();
        assert!(passing[0].position.x > 0.2 && passing[1].position.x < -0.2, "{passing:?}");
    }

    /// A person that could overtake only by leaving their own way does not.
    #[test]
    fn a_faster_person_behind_follows() {
        let disc = Shape::Disc { radius: 0.25 };
        let crowd = [
            Walker::new(disc, (0.0, -3.0), (0.0, 20.0), 1.8),
            Walker::new(disc, (0.0, -1.0), (0.0, 20.0), 1.0),
        ];
        let all = run(&crowd, &[], 100);
        let last = all.last().unwrap();
        assert!(all.iter().all(|states| states[0].position.x == 0.0), "{last:?}");
        let apart = last[1].position.y - last[0].position.y;
        // Half of what is between them may be walked in a step of 0.1 s.
        assert!((apart - 0.7).abs() < 1e-3 && (last[0].velocity.y - 1.0).abs() < 0.1, "{last:?}");
    }

    /// A gap straight ahead that is too narrow is not a way, and neither is one between boxes that stand one behind the other.
    #[test]
    fn boxes_without_a_way_between_them_are_walked_around_as_one() {
        let at = |x: f64, y: f64, length: f64, width: f64| Footprint {
            centre: Vector2::new(x, y),
            heading: Vector2::x(),
            shape: Shape::Rectangle { length, width },
        };
        let disc = Shape::Disc { radius: 0.25 };
        for boxes in [
            [at(-2.4, 0.0, 4.5, 1.8), at(2.4, 0.0, 4.5, 1.8)],
            [at(-2.5, 0.0, 4.5, 1.8), at(2.5, 0.0, 4.5, 1.8)],
            [at(-1.0, 0.0, 2.2, 0.4), at(1.0, -0.7, 2.2, 0.4)],
            [at(1.0, 0.0, 2.2, 0.4), at(-1.0, -0.7, 2.2, 0.4)],
        ] {
            for x in [-1.0, -0.2, -1e-9, 0.0, 0.1, 0.7] {
                let walker = Walker::new(disc, (x, -3.0), (x, 3.0), 1.4);
                let all = run(&[walker], &boxes, 150);
                let last = &all.last().unwrap()[0];
                assert!((last.position - Vector2::new(x, 3.0)).norm() < 1e-9, "{x}, {boxes:?}: {last:?}");
            }
        }
        // Through one that is wide enough the way leads straight on.
        let boxes = [at(-2.6, 0.0, 4.5, 1.8), at(2.6, 0.0, 4.5, 1.8)];
        let all = run(&[Walker::new(disc, (0.0, -3.0), (0.0, 3.0), 1.4)], &boxes, 60);
        assert!(
            all.iter().all(|states| states[0].position.x == 0.0) && all.last().unwrap()[0].position.y == 3.0
        );
    }

    /// Before a wall they go along it to their right, and around it.
    #[test]
    fn a_box_is_walked_around() {
        let car = Footprint {
            centre: Vector2::zeros(),
            heading: Vector2::x(),
            shape: Shape::Rectangle { length: 4.0, width: 1.8 },
        };
        let walker = Walker::new(Shape::Disc { radius: 0.25 }, (0.5, -3.0), (0.5, 3.0), 1.4);
        let all = run(&[walker], &[car], 100);
        let last = &all.last().unwrap()[0];
        assert!((last.position - Vector2::new(0.5, 3.0)).norm() < 1e-9, "{last:?}");
        assert!(all.iter().any(|states| states[0].position.x > 2.2));
    }
}
