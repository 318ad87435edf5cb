//! Which gap in a stream of vehicles a pedestrian takes: its size, how many went by before, how soon after a vehicle the pedestrian goes,
//! what is left when it is through, and whether it steps back.

use nalgebra::Vector2;

use super::travel::standing;
use scenario::{Absence, Metric, MetricKind, MetricRange, Path, Scope, Stake, Worst};
use scenario::{Declaration, Dimension, Located, Parameter};
use sim::Step;
use sim::measure::{Encounters, End, Meter, MetricContext, Open, Slot, StreamWay, difference, lerp, meters};

const FRONTS: &str = "a vehicle has passed once its front is past where the lane and the pedestrian's way meet; entry by the centre as in \
     crossing_duration";

pub fn gap_taken() -> Metric {
    let declaration = Declaration::new(
        "gap_taken",
        "The gap of the stream into which the pedestrian enters its lane when it gets across: between the declared arrivals of the vehicle \
         that passed last and of the one that is next. Undefined if the pedestrian never gets across, or enters before the first vehicle has \
         passed or after the last one, or if the vehicles do not pass in their order.",
    )
    .source(FRONTS)
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Stream,
        worst: Worst::Smallest,
        // Who goes in no gap of the stream says nothing of those that people take.
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::Company,
        meters: meters(|context| Box::new(GapTaken(Crosser::new(context)))),
    }
}

/// A pedestrian and the stream whose lane it may cross.
struct Crosser {
    way: StreamWay,
    /// See [`scenario::TrafficStream::arrivals`].
    arrivals: Vec<f64>,
}

impl Crosser {
    fn new(context: &MetricContext) -> Self {
        let way = StreamWay::new(context.world, context.stream, context.pedestrian);
        Self { way, arrivals: context.world.streams[context.stream].arrivals.clone() }
    }

    /// The gap before the vehicle of this index, s.
    fn gap(&self, next: usize) -> f64 {
        difference(self.arrivals[next], self.arrivals[next - 1])
    }

    /// When the pedestrian entered the lane to get across, s, and where in the stream that was.
    fn entry(&self, encounters: &Encounters) -> Option<(f64, Slot)> {
        let entered = self.way.crossing(encounters)?.entered;
        Some((entered, StreamWay::slot(&self.way.fronts(encounters), entered)))
    }

    /// Before when the pedestrian cannot have entered the lane, s, if it may yet get across: when it did where it is in the lane when time is
    /// up. `None` where nothing is left to come of it.
    fn earliest_entry(&self, encounters: &Encounters, end: &End) -> Option<f64> {
        let encounter = self.way.encounter(encounters)?;
        let waits = encounter.crosses && encounter.appeared.is_some() && encounter.crossing.is_none();
        let inside = encounter.last_entry.filter(|_| encounter.is_in_lane());
        (waits && !self.way.was_hit(encounters)).then(|| inside.unwrap_or(end.time))
    }

    /// How many whole gaps went by until a moment (s) while the pedestrian was there and might go.
    fn missed(&self, encounters: &Encounters, until: f64) -> Option<f64> {
        let let_go = self.way.encounter(encounters)?.let_go?;
        let fronts = self.way.fronts(encounters);
        let gone = fronts.windows(2).filter(|pair| pair[0] >= let_go && pair[1] <= until);
        Some(gone.count() as f64)
    }
}

struct GapTaken(Crosser);

impl Meter for GapTaken {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        match self.0.entry(encounters)? {
            (_, Slot::Gap(next)) => Some(self.0.gap(next)),
            _ => None,
        }
    }

    fn open(&self, encounters: &Encounters, end: &End) -> Option<Open> {
        let earliest = self.0.earliest_entry(encounters, end)?;
        let first = match StreamWay::slot(&self.0.way.fronts(encounters), earliest) {
            Slot::BeforeFirst | Slot::OutOfOrder => 1,
            Slot::Gap(next) => next,
            Slot::AfterLast => return None,
        };
        let gaps = || (first..self.0.arrivals.len()).map(|next| self.0.gap(next));
        Some(Open { low: gaps().reduce(f64::min)?, high: gaps().reduce(f64::max)? })
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.0.entry(encounters).map(|(entered, _)| entered)
    }
}

pub fn gaps_missed() -> Metric {
    let declaration = Declaration::new(
        "gaps_missed",
        "How many whole gaps of the stream went by while the pedestrian was there and might go, before the one that it took; 0 if it entered \
         before the first vehicle had passed. Undefined if it never gets across, or only after the last vehicle: who outlasts a stream would \
         have missed nobody knows how many more.",
    )
    .source(FRONTS)
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::NUMBER),
        scope: Scope::Stream,
        worst: Worst::Largest,
        // Counted as no end of gaps, who is hit at the first would pass for somebody who waits; counted as so many as there were, a short
        // stream would make everybody bold.
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::Company,
        meters: meters(|context| Box::new(GapsMissed(Crosser::new(context)))),
    }
}

struct GapsMissed(Crosser);

impl Meter for GapsMissed {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        match self.0.entry(encounters)? {
            (_, Slot::BeforeFirst) => Some(0.0),
            (entered, Slot::Gap(_)) => self.0.missed(encounters, entered),
            (_, Slot::AfterLast | Slot::OutOfOrder) => None,
        }
    }

    fn open(&self, encounters: &Encounters, end: &End) -> Option<Open> {
        // Of who still waits when the stream is over, too: more vehicles would have been more gaps.
        let earliest = self.0.earliest_entry(encounters, end)?;
        Some(Open::at_least(self.0.missed(encounters, earliest).unwrap_or(0.0)))
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.0.entry(encounters).map(|(entered, _)| entered)
    }
}

pub fn entry_after_previous() -> Metric {
    let declaration = Declaration::new(
        "entry_after_previous",
        "From the front of the stream's previous vehicle passing the pedestrian's way to the pedestrian's entry into the lane when it gets \
         across. Undefined if it never does, or if no vehicle passed before.",
    )
    .source(FRONTS)
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Stream,
        worst: Worst::Smallest,
        absence: Absence::Open,
        range: MetricRange::WithinRun,
        stake: Stake::Company,
        meters: meters(|context| Box::new(EntryAfterPrevious(Crosser::new(context)))),
    }
}

struct EntryAfterPrevious(Crosser);

impl EntryAfterPrevious {
    /// When the last front passed until a moment, s.
    fn previous(&self, encounters: &Encounters, until: f64) -> Option<f64> {
        let passed = self.0.way.fronts(encounters).into_iter().filter(|front| *front <= until);
        passed.reduce(f64::max).filter(|front| front.is_finite())
    }
}

impl Meter for EntryAfterPrevious {
    fn value(&self, encounters: &Encounters) -> Option<f64> {
        let (entered, _) = self.0.entry(encounters)?;
        Some(difference(entered, self.previous(encounters, entered)?))
    }

    fn open(&self, encounters: &Encounters, end: &End) -> Option<Open> {
        let earliest = self.0.earliest_entry(encounters, end)?;
        if self.0.way.fronts(encounters).iter().any(|front| *front > earliest) {
            return Some(Open::at_least(0.0));
        }
        Some(Open::at_least(difference(earliest, self.previous(encounters, earliest)?)))
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.0.entry(encounters).map(|(entered, _)| entered)
    }
}

pub fn time_left_on_leaving() -> Metric {
    let declaration = Declaration::new(
        "time_left_on_leaving",
        "When the pedestrian's centre leaves a lane on the other side: how long the front of the lane's next vehicle still takes to the \
         pedestrian's way. Of a vehicle that has braked since the pedestrian might go, how long it would have taken had it not. 0 if a vehicle is \
         beside the pedestrian or over its way, passed while it was in the lane, has come to stand, would have been there but for braking, or \
         hit the pedestrian. Undefined if the pedestrian never crosses the lane, or no vehicle is to come.",
    )
    .source(
        "distance along the lane from the front, over the largest speed since the pedestrian might go; no later than any of its arrivals at the \
         speeds that it had while the pedestrian was in the lane",
    )
    .parameters([
        Parameter::whole("lane", 0, (0, 15), "The lane, as vehicles name theirs.", "the first lane"),
        standing("standing"),
    ])
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Quantity(Dimension::TIME),
        scope: Scope::Pedestrian,
        worst: Worst::Smallest,
        // Nobody comes: that is safe after a last vehicle, and says nothing of who never went.
        absence: Absence::Open,
        range: MetricRange::NotNegative,
        stake: Stake::Entry,
        meters: meters(|context| Box::new(TimeLeft::new(context))),
    }
}

struct TimeLeft {
    pedestrian: usize,
    /// All that drive on the lane.
    vehicles: Vec<Coming>,
    /// At or below this speed a vehicle stands, m/s.
    standing: f64,
    /// When the pedestrian last entered the lane, s.
    entered: Option<f64>,
    /// When it left it on the other side, and what was left then if anybody was to come, s.
    left: Option<(f64, Option<f64>)>,
}

/// A vehicle that may be next.
struct Coming {
    /// In the world.
    vehicle: usize,
    half_length: f64,
    /// Where it meets the pedestrian's way if that leads straight to the goal, m along its lane.
    expected_place: f64,
    /// Whether it has moved in the run.
    has_moved: bool,
    /// The largest speed that it has had since the pedestrian might go, m/s.
    fastest: f64,
    /// Whether its front had yet to pass when the pedestrian entered the lane.
    was_ahead: bool,
    /// The earliest that it would have come at any speed that it had since then, s.
    earliest: f64,
}

/// A vehicle at one moment of a step, seen from the pedestrian's way.
struct Moment {
    /// s
    time: f64,
    /// From the front to the way, m; negative past it.
    ahead: f64,
    /// m/s
    speed: f64,
}

impl Coming {
    fn at(&self, step: &Step, places: (Located, Located), part: f64) -> Moment {
        let (before, after) = (&step.before.vehicles[self.vehicle], &step.after.vehicles[self.vehicle]);
        let travelled = lerp(before.motion.travelled, after.motion.travelled, part);
        let place = lerp(places.0.along, places.1.along, part);
        Moment {
            time: step.time + part * step.duration,
            ahead: difference(place, travelled + self.half_length),
            speed: lerp(before.motion.speed, after.motion.speed, part),
        }
    }

    fn enter(&mut self, moment: &Moment) {
        self.was_ahead = moment.ahead > 0.0;
        self.earliest = f64::INFINITY;
    }

    /// Takes a moment at which the pedestrian is in the lane.
    fn follow(&mut self, moment: &Moment, standing: f64) {
        if !self.was_ahead {
            return;
        }
        if moment.ahead <= 0.0 {
            self.earliest = self.earliest.min(moment.time);
        } else if moment.speed > standing {
            self.earliest = self.earliest.min(moment.time + moment.ahead / moment.speed);
        }
    }

    /// What is left as the pedestrian leaves the lane, s; `None` if the vehicle is not to come.
    fn left(&self, moment: &Moment, standing: f64) -> Option<f64> {
        if moment.ahead <= 0.0 {
            let is_beside = moment.ahead + 2.0 * self.half_length >= 0.0;
            return (is_beside || self.was_ahead).then_some(0.0);
        }
        if !self.has_moved {
            return None;
        }
        if moment.speed <= standing {
            return Some(0.0);
        }
        let undisturbed = moment.ahead / self.fastest.max(moment.speed);
        Some(undisturbed.min(difference(self.earliest, moment.time)).max(0.0))
    }
}

impl TimeLeft {
    fn new(context: &MetricContext) -> Self {
        let lane = context.settings.number("lane");
        let person = &context.world.pedestrians[context.pedestrian];
        let on_lane = context.world.vehicles.iter().enumerate();
        let on_lane = on_lane.filter(|(_, car)| car.road == 0 && car.lane as f64 == lane);
        let coming = |(vehicle, car): (usize, &scenario::VehicleSetup)| Coming {
            vehicle,
            half_length: car.length / 2.0,
            expected_place: person.met_by(&context.world.path_of(car)),
            has_moved: false,
            fastest: 0.0,
            was_ahead: false,
            earliest: f64::INFINITY,
        };
        Self {
            pedestrian: context.pedestrian,
            vehicles: on_lane.map(coming).collect(),
            standing: context.settings.number("standing"),
            entered: None,
            left: None,
        }
    }

    /// When a vehicle of the lane hit the pedestrian who crosses it, s.
    fn hit(&self, encounters: &Encounters) -> Option<f64> {
        let pairs = self.vehicles.iter().map(|one| encounters.pair(one.vehicle, self.pedestrian));
        let contacts = pairs.filter(|pair| pair.crosses).filter_map(|pair| pair.contact);
        contacts.map(|contact| contact.time).reduce(f64::min)
    }
}

impl Meter for TimeLeft {
    fn observe(&mut self, step: &Step, encounters: &Encounters) {
        if self.left.is_some() {
            return;
        }
        for one in &mut self.vehicles {
            let states = (&step.before.vehicles[one.vehicle], &step.after.vehicles[one.vehicle]);
            let fastest = states.0.motion.speed.max(states.1.motion.speed);
            one.has_moved |= fastest > self.standing;
            if step.may_go(self.pedestrian) {
                one.fastest = one.fastest.max(fastest);
            }
        }
        // All of them drive on one lane.
        let Some(first) = self.vehicles.first() else { return };
        let encounter = encounters.pair(first.vehicle, self.pedestrian);
        let Some(entered) = encounter.last_entry.filter(|_| step.before.pedestrians[self.pedestrian].present)
        else {
            return;
        };
        let part = |time: f64| ((time - step.time) / step.duration).clamp(0.0, 1.0);
        let enters = self.entered != Some(entered);
        self.entered = Some(entered);
        let until = encounter.crossing.map_or(1.0, |crossing| part(crossing.left));
        let mut least: Option<f64> = None;
        for one in &mut self.vehicles {
            let Some(places) = encounters.pair(one.vehicle, self.pedestrian).places else { continue };
            if enters {
                let moment = one.at(step, places, part(entered));
                one.enter(&moment);
                one.follow(&moment, self.standing);
            }
            let moment = one.at(step, places, until);
            one.follow(&moment, self.standing);
            if let Some(left) = encounter.crossing.and_then(|_| one.left(&moment, self.standing)) {
                least = Some(least.map_or(left, |least| least.min(left)));
            }
        }
        self.left = encounter.crossing.map(|crossing| (crossing.left, least));
    }

    fn value(&self, encounters: &Encounters) -> Option<f64> {
        if self.hit(encounters).is_some() { Some(0.0) } else { self.left?.1 }
    }

    fn open(&self, encounters: &Encounters, _: &End) -> Option<Open> {
        let encounter = encounters.pair(self.vehicles.first()?.vehicle, self.pedestrian);
        let waits = encounter.crosses && encounter.appeared.is_some() && encounter.crossing.is_none();
        let comes = |one: &Coming| {
            let place = one.expected_place - one.half_length;
            encounters.passage(one.vehicle).reached(place).moment() == f64::INFINITY
        };
        let open = waits && !encounters.was_hit(self.pedestrian) && self.vehicles.iter().any(comes);
        open.then(|| Open::at_least(0.0))
    }

    fn instant(&self, encounters: &Encounters) -> Option<f64> {
        self.hit(encounters).or(self.left.and_then(|(time, left)| left.map(|_| time)))
    }
}

pub fn step_back() -> Metric {
    let declaration = Declaration::new(
        "step_back",
        "Whether the pedestrian entered a lane and left it again by the side that it came from; undefined if it never appears.",
    )
    .source("by its centre, each lane of the road by itself, whether or not anybody drives there")
    .on_request();
    Metric {
        declaration,
        kind: MetricKind::Flag,
        scope: Scope::Pedestrian,
        worst: Worst::Largest,
        absence: Absence::Open,
        range: MetricRange::YesOrNo,
        stake: Stake::Company,
        meters: meters(|context| Box::new(StepBack::new(context))),
    }
}

struct StepBack {
    pedestrian: usize,
    appeared: bool,
    /// Of who crosses the road.
    lanes: Vec<LaneWalk>,
    half_lane: f64,
    /// s
    stepped_back: Option<f64>,
}

/// A pedestrian and one lane.
struct LaneWalk {
    path: Path,
    /// Makes distances beside the lane grow on the way to the goal.
    sign: f64,
    /// How far the pedestrian is across the lane's centre line, m; `None` until it is there.
    before: Option<f64>,
    /// Whether it came from its own side; `None` outside of the lane.
    inside: Option<bool>,
}

impl LaneWalk {
    /// How far across the centre line a place is, m; `None` so far inside a bend that nobody knows which part of it is meant.
    fn across(&self, place: Vector2<f64>) -> Option<f64> {
        let place = self.path.locate(place);
        (!place.ambiguous).then_some(self.sign * place.beside)
    }

    /// The share of the way after which the pedestrian leaves the lane by the side that it came from.
    fn walk_to(&mut self, after: f64, half: f64) -> Option<f64> {
        let Some(before) = self.before.replace(after) else {
            self.inside = (-half <= after && after < half).then_some(true);
            return None;
        };
        if before < -half && after >= -half {
            self.inside = Some(true);
        }
        if before >= half && after < half {
            self.inside = Some(false);
        }
        let part = |line: f64| (line - before) / (after - before);
        match self.inside {
            Some(own) if after < -half => {
                self.inside = None;
                own.then(|| part(-half))
            }
            Some(own) if after >= half => {
                self.inside = None;
                (!own).then(|| part(half))
            }
            _ => None,
        }
    }
}

impl StepBack {
    fn new(context: &MetricContext) -> Self {
        let (road, person) = (&context.world.road, &context.world.pedestrians[context.pedestrian]);
        let lanes = if person.crosses(road) { 0..road.lanes.len() } else { 0..0 };
        let lane = |index: usize| LaneWalk {
            path: road.path(index),
            sign: person.side.walking_sign(),
            before: None,
            inside: None,
        };
        Self {
            pedestrian: context.pedestrian,
            appeared: false,
            lanes: lanes.map(lane).collect(),
            half_lane: road.lane_width / 2.0,
            stepped_back: None,
        }
    }
}

impl Meter for StepBack {
    fn observe(&mut self, step: &Step, _: &Encounters) {
        let (old, new) =
            (&step.before.pedestrians[self.pedestrian], &step.after.pedestrians[self.pedestrian]);
        if !old.present || self.stepped_back.is_some() {
            return;
        }
        let begins = !std::mem::replace(&mut self.appeared, true);
        for lane in &mut self.lanes {
            if let Some(first) = lane.across(old.position).filter(|_| begins) {
                lane.walk_to(first, self.half_lane);
            }
            let Some(after) = lane.across(new.position) else { continue };
            if let Some(part) = lane.walk_to(after, self.half_lane) {
                self.stepped_back = Some(step.time + part * step.duration);
            }
        }
    }

    fn value(&self, _: &Encounters) -> Option<f64> {
        self.appeared.then(|| f64::from(self.stepped_back.is_some()))
    }

    fn open(&self, encounters: &Encounters, _: &End) -> Option<Open> {
        let is_over = |lane: &LaneWalk| lane.before.is_some_and(|across| across >= self.half_lane);
        let goes_on = self.appeared && self.stepped_back.is_none() && !self.lanes.iter().all(is_over);
        (goes_on && !encounters.was_hit(self.pedestrian)).then_some(Open { low: 0.0, high: 1.0 })
    }

    fn instant(&self, _: &Encounters) -> Option<f64> {
        self.stepped_back
    }
}
