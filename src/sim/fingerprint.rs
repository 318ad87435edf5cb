//! A run's fingerprint: a number that changes when any bit of its course changes.
//!
//! It is made of the states after whole steps of the simulation, also where the run ends inside the last of them.

use super::arrival::StreamVehicles;
use super::observer::{Ending, Observer, Step};
use super::solid::Solid;
use scenario::agent::{PedestrianState, Snapshot, VehicleState};
use scenario::{TrafficStream, World};

/// Mixes every state of a run into 64 bits. Two runs with the same fingerprint took the same course, bit for bit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fingerprint(u64);

impl Default for Fingerprint {
    fn default() -> Self {
        Self(0x9e37_79b9_7f4a_7c15)
    }
}

impl Fingerprint {
    /// The number: equal for two runs that are equal in every bit, and different for others but by chance.
    pub fn value(self) -> u64 {
        self.0
    }

    fn mix(&mut self, number: f64) {
        self.mix_bits(number.to_bits());
    }

    fn mix_bits(&mut self, bits: u64) {
        let mixed = (self.0 ^ bits).wrapping_mul(0xff51_afd7_ed55_8ccd);
        self.0 = mixed ^ (mixed >> 32);
    }

    fn mix_vehicle(&mut self, car: &VehicleState) {
        self.mix(car.motion.travelled);
        self.mix(car.motion.speed);
        if let Some(steered) = &car.steered {
            self.mix(steered.centre.x);
            self.mix(steered.centre.y);
            self.mix(steered.heading.y);
        }
    }

    fn mix_people(&mut self, people: &[PedestrianState]) {
        for person in people {
            self.mix(person.position.x);
            self.mix(person.position.y);
            self.mix(person.velocity.y);
        }
    }
}

impl Observer for Fingerprint {
    fn observe(&mut self, step: &Step) {
        step.whole.vehicles.iter().for_each(|car| self.mix_vehicle(car));
        self.mix_people(&step.whole.pedestrians);
    }
}

/// The fingerprint of a run in a world that may have streams. Of their vehicles it has those that the run waited for or that touched anything,
/// in an order in which neither the order of declaration nor the length of a stream counts; without streams it is that of everybody.
#[derive(Debug, Clone)]
pub struct RunFingerprint {
    /// Of everybody who is in no stream.
    others: Fingerprint,
    /// Indices of the vehicles that are in no stream.
    alone: Vec<usize>,
    members: Vec<Member>,
    streams: StreamVehicles,
}

/// A vehicle of a stream.
#[derive(Debug, Clone)]
struct Member {
    vehicle: usize,
    fingerprint: Fingerprint,
    touched: bool,
    counts: bool,
}

impl RunFingerprint {
    /// Of a run that has not begun.
    pub fn new(world: &World) -> Self {
        let mut streams: Vec<&TrafficStream> = world.streams.iter().collect();
        streams.sort_by(|one, other| one.name.cmp(&other.name));
        let members = streams.iter().flat_map(|stream| &stream.vehicles).map(|vehicle| Member {
            vehicle: *vehicle,
            fingerprint: Fingerprint::default(),
            touched: false,
            counts: true,
        });
        let members: Vec<Member> = members.collect();
        let is_alone = |vehicle: &usize| members.iter().all(|member| member.vehicle != *vehicle);
        Self {
            others: Fingerprint::default(),
            alone: (0..world.vehicles.len()).filter(is_alone).collect(),
            members,
            streams: StreamVehicles::new(world),
        }
    }

    /// As [`Fingerprint::value`].
    pub fn value(&self) -> u64 {
        let counted = self.members.iter().filter(|member| member.counts || member.touched);
        let mix = |mut all: Fingerprint, member: &Member| {
            all.mix_bits(member.fingerprint.value());
            all
        };
        counted.fold(self.others, mix).value()
    }
}

impl Observer for RunFingerprint {
    fn observe(&mut self, step: &Step) {
        if self.members.is_empty() {
            self.others.observe(step);
            return;
        }
        let cars = &step.whole.vehicles;
        self.alone.iter().for_each(|vehicle| self.others.mix_vehicle(&cars[*vehicle]));
        self.others.mix_people(&step.whole.pedestrians);
        for member in &mut self.members {
            member.fingerprint.mix_vehicle(&cars[member.vehicle]);
            let own = Solid::Vehicle(member.vehicle);
            member.touched |= step.contacts.iter().any(|touch| touch.first == own || touch.second == own);
        }
    }

    fn end(&mut self, ending: &Ending, last: &Snapshot) {
        for vehicle in self.streams.not_awaited(ending, last) {
            let own = self.members.iter_mut().find(|member| member.vehicle == vehicle);
            own.into_iter().for_each(|member| member.counts = false);
        }
    }
}
