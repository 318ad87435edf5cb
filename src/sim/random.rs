//! Who draws in a run, and what for: one stream per agent and purpose, so that a draw added to one never shifts another's.

use numbers::random::{Stream, derive_seed, ranks};
use scenario::World;

/// Who draws: a pedestrian or a vehicle, by its [rank](numbers::random::ranks) among its kind. A draw added to one
/// agent never shifts another's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Agent {
    /// The pedestrian of this rank.
    Pedestrian(usize),
    /// The vehicle of this rank.
    Vehicle(usize),
}

/// What an agent draws for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// Choices and parameters drawn once per run.
    Trait = 0,
    /// Choices made during the run.
    Decision = 1,
    /// Noise of what is seen.
    Perception = 2,
    /// Noise of movement.
    Motion = 3,
    /// Noise and losses of a vehicle's sensors, whoever drives it.
    Sensing = 4,
}

/// The stream of one agent for one purpose in the run with seed `seed`.
pub fn stream(seed: u64, agent: Agent, purpose: Purpose) -> Stream {
    let (kind, index) = match agent {
        Agent::Pedestrian(index) => (1, index),
        Agent::Vehicle(index) => (2, index),
    };
    Stream::numbered(seed, kind << 56 | (index as u64) << 8 | purpose as u64)
}

/// So many vehicles of a stream have ranks of their own.
const STREAM_RANKS: usize = 1 << 20;

/// The ranks of all vehicles of a world, in its order. Those of a stream have ranks beyond all others, by the rank of the stream and by their
/// places in it, so that a vehicle more at the end of a stream shifts no draws of anybody.
pub fn vehicle_ranks(world: &World) -> Vec<usize> {
    let names: Vec<&str> = world.streams.iter().map(|stream| stream.name.as_str()).collect();
    let mut all: Vec<Option<usize>> = vec![None; world.vehicles.len()];
    for (stream, rank) in world.streams.iter().zip(ranks(&names)) {
        for (place, vehicle) in stream.vehicles.iter().enumerate() {
            all[*vehicle] = Some((rank + 1) * STREAM_RANKS + place);
        }
    }
    let alone = world.vehicles.iter().zip(&all).filter(|(_, rank)| rank.is_none());
    let names: Vec<&str> = alone.map(|(setup, _)| setup.name.as_str()).collect();
    let mut others = ranks(&names).into_iter();
    all.into_iter()
        .map(|rank| rank.or_else(|| others.next()).expect("one rank for each of the others"))
        .collect()
}

/// The stream of what a scenario declares to be drawn, by its name, in the run with seed `seed`. What else is drawn shifts nothing, and no
/// number of a stream meets those of agents. `attempt` counts from 0 where a run is drawn again.
pub fn declared(seed: u64, name: &str, attempt: u64) -> Stream {
    Stream::numbered(derive_seed(seed, &format!("draw/{name}")), attempt)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_golden() {
        let mut walker = stream(42, Agent::Pedestrian(0), Purpose::Perception);
        let draws: Vec<_> = (0..4).map(|_| walker.normal()).collect();
        insta::assert_debug_snapshot!(draws);
    }

    #[test]
    fn declared_draws_are_golden_and_differ_by_seed_name_and_attempt() {
        let first = |seed, name, attempt| declared(seed, name, attempt).uniform();
        // A change here changes every drawn run.
        assert_eq!(first(42, "speed", 0), 0.061_576_262_255_460_87);
        let others = [first(43, "speed", 0), first(42, "gap", 0), first(42, "speed", 1)];
        assert!(others.iter().all(|other| *other != first(42, "speed", 0)));
    }

    #[test]
    fn streams_differ_by_seed_agent_and_purpose() {
        let first = |seed, agent, purpose| stream(seed, agent, purpose).uniform();
        let base = first(1, Agent::Pedestrian(0), Purpose::Decision);
        assert_eq!(base, first(1, Agent::Pedestrian(0), Purpose::Decision));
        assert_ne!(base, first(2, Agent::Pedestrian(0), Purpose::Decision));
        assert_ne!(base, first(1, Agent::Pedestrian(1), Purpose::Decision));
        assert_ne!(base, first(1, Agent::Vehicle(0), Purpose::Decision));
        assert_ne!(base, first(1, Agent::Pedestrian(0), Purpose::Motion));
    }
}
