//! A stream of vehicles and a pedestrian who may cross its lane: when each vehicle comes to the pedestrian's way, and between which two
//! of them the pedestrian enters the lane.

use super::encounter::{Encounter, Encounters, LaneCrossing};
use scenario::World;

/// The vehicles of a stream as a pedestrian meets them.
#[derive(Debug, Clone)]
pub struct StreamWay {
    /// Of the pedestrian, in the world.
    pedestrian: usize,
    /// In the order in which they are declared to arrive.
    members: Vec<Member>,
}

#[derive(Debug, Clone)]
struct Member {
    /// Of the vehicle, in the world.
    vehicle: usize,
    /// m
    half_length: f64,
    /// Where lane and way meet if the pedestrian walks straight to its goal, m along the vehicle's lane.
    expected_place: f64,
}

/// Where in a stream something lies in time.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Slot {
    /// Before the front of the first vehicle passed.
    BeforeFirst,
    /// After the front of the vehicle before this one passed and before the front of this one did; counted in the stream, from 1.
    Gap(usize),
    /// After the front of the last vehicle passed.
    AfterLast,
    /// The vehicles do not pass in their order.
    OutOfOrder,
}

impl StreamWay {
    /// Of the stream and the pedestrian with these indices.
    pub fn new(world: &World, stream: usize, pedestrian: usize) -> Self {
        let member = |vehicle: &usize| {
            let car = &world.vehicles[*vehicle];
            let expected_place = world.pedestrians[pedestrian].met_by(&world.path_of(car));
            Member { vehicle: *vehicle, half_length: car.length / 2.0, expected_place }
        };
        Self { pedestrian, members: world.streams[stream].vehicles.iter().map(member).collect() }
    }

    /// The pedestrian and the first vehicle of the stream, on whose lane all of them drive.
    pub fn encounter<'e>(&self, encounters: &'e Encounters) -> Option<&'e Encounter> {
        Some(encounters.pair(self.members.first()?.vehicle, self.pedestrian))
    }

    /// The crossing of the lane that was carried through.
    pub fn crossing(&self, encounters: &Encounters) -> Option<LaneCrossing> {
        self.encounter(encounters)?.crossing
    }

    /// Whether any vehicle has hit the pedestrian.
    pub fn was_hit(&self, encounters: &Encounters) -> bool {
        encounters.was_hit(self.pedestrian)
    }

    /// When the front of each vehicle passed the pedestrian's way, s: minus infinity before the start, infinity if not yet. The way is where
    /// the pedestrian passed the centre line of the lane when it got across, or else where it would.
    pub fn fronts(&self, encounters: &Encounters) -> Vec<f64> {
        let front = |member: &Member| {
            let encounter = encounters.pair(member.vehicle, self.pedestrian);
            let is_its =
                |crossing: LaneCrossing, time: f64| crossing.entered <= time && time <= crossing.left;
            let passing = encounter.crossing.and_then(|crossing| {
                let mut all = encounter.passings.iter().rev();
                all.find(|passing| passing.towards_goal && is_its(crossing, passing.time))
            });
            let place = passing.map_or(member.expected_place, |passing| passing.place);
            encounters.passage(member.vehicle).reached(place - member.half_length).moment()
        };
        self.members.iter().map(front).collect()
    }

    /// Where in the stream whose `fronts` these are a moment lies, s.
    pub fn slot(fronts: &[f64], time: f64) -> Slot {
        let passed = fronts.iter().take_while(|front| **front <= time).count();
        if fronts[passed..].iter().any(|front| *front <= time) || !fronts[..passed].is_sorted() {
            return Slot::OutOfOrder;
        }
        match passed {
            0 => Slot::BeforeFirst,
            all if all == fronts.len() => Slot::AfterLast,
            next => Slot::Gap(next),
        }
    }

    /// Whether the last vehicle had passed before the pedestrian, who was there, might go and was not hit, entered the lane to get across, or
    /// passed and the pedestrian did not get across at all.
    pub fn is_outlasted(&self, encounters: &Encounters) -> bool {
        let Some(encounter) = self.encounter(encounters) else { return false };
        if !encounter.crosses || encounter.let_go.is_none() {
            return false;
        }
        let time = match encounter.crossing {
            Some(crossing) => crossing.entered,
            None if self.was_hit(encounters) => return false,
            None => f64::MAX,
        };
        self.fronts(encounters).iter().all(|front| *front <= time)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_lies_before_between_or_after_fronts() {
        const NEVER: f64 = f64::INFINITY;
        let of = |time| StreamWay::slot(&[1.0, 3.0, NEVER], time);
        assert_eq!([of(0.5), of(1.0), of(2.9)], [Slot::BeforeFirst, Slot::Gap(1), Slot::Gap(1)]);
        assert_eq!([of(3.0), of(1e9)], [Slot::Gap(2), Slot::Gap(2)]);
        assert_eq!(StreamWay::slot(&[f64::NEG_INFINITY, 1.0], 2.0), Slot::AfterLast);
        // Somebody else drove through a vehicle that stands.
        assert_eq!(StreamWay::slot(&[1.0, NEVER, 2.0], 2.5), Slot::OutOfOrder);
        assert_eq!(StreamWay::slot(&[2.0, 1.0, NEVER], 2.5), Slot::OutOfOrder);
    }
}
