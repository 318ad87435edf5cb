//! A run's fingerprint: a number that changes when any bit of its course changes.
//!
//! It is made of the states after whole steps of the simulation, also where the run ends inside the last of them.

use super::observer::{Observer, Step};

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
        let mixed = (self.0 ^ number.to_bits()).wrapping_mul(0xff51_afd7_ed55_8ccd);
        self.0 = mixed ^ (mixed >> 32);
    }
}

impl Observer for Fingerprint {
    fn observe(&mut self, step: &Step) {
        for car in &step.whole.vehicles {
            self.mix(car.motion.travelled);
            self.mix(car.motion.speed);
            if let Some(steered) = &car.steered {
                self.mix(steered.centre.x);
                self.mix(steered.centre.y);
                self.mix(steered.heading.y);
            }
        }
        for person in &step.whole.pedestrians {
            self.mix(person.position.x);
            self.mix(person.position.y);
            self.mix(person.velocity.y);
        }
    }
}
