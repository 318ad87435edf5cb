//! The adversarial jaywalker: a state machine over forces, restated from the observed behaviour of the research code
//! behind Muktadir & Whitehead (IEEE IV 2022).
//!
//! It is initialising, waiting, crossing, frozen (stopped in the lane), in survival (turning back) or finished. When
//! it starts is a gap model's matter; how it moves, that of the forces.

mod agent;
mod declaration;
mod forces;
mod gap;
mod perception;

use agent::{Individuality, Jaywalker, Tactic};
use declaration::{declaration, stop_times};

use super::{PedestrianContext, PedestrianModel};
use crate::pedestrian::across::check_across;
use scenario::{Dimension, SignalConduct, show_outside};
use sim::random::{Agent, Purpose, stream};
use sim::{ModelError, Pedestrian, Stated, StatedBy};

pub fn jaywalker() -> PedestrianModel {
    let declaration = declaration();
    PedestrianModel::new(declaration, build).in_legs().signals(SignalConduct::Ignores)
}

/// Shortest and longest step that the model is checked at, s.
const STEPS: (f64, f64) = (0.01, 0.05);

fn build(context: &PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> {
    check_across(context, "jaywalker")?;
    check_place(context)?;
    let settings = context.settings;
    let (shortest, longest) = stop_times(settings)?;
    let me = Agent::Pedestrian(context.rank);
    // Drawn in every run and always in this order, so that presets stay aligned under one seed.
    let mut traits = stream(context.seed, me, Purpose::Trait);
    let drawn = Individuality {
        tactic: [Tactic::Dash, Tactic::Freeze, Tactic::Rewind][traits.index(3)],
        timing_error: traits.uniform_in(0.9, 1.1),
        stop_time: traits.uniform_in(shortest, longest),
    };
    let decisions = stream(context.seed, me, Purpose::Decision);
    Ok(Box::new(Jaywalker::new(settings, drawn, context.setup.side, decisions)))
}

/// It needs a kerb, to start on the pavement behind it, a goal across the road, and a step that it is checked at.
fn check_place(context: &PedestrianContext) -> Result<(), ModelError> {
    let road = &context.world.road;
    if !road.kerbs {
        return Err(ModelError::with_hint(
            "`jaywalker` needs a road with kerbs: it waits on the pavement and turns back only on the carriageway",
            "take `no kerbs` out of the road, or take the model `scripted`",
        ));
    }
    let (start, goal, side) = (context.setup.start, context.setup.goal, context.setup.side);
    let sign = side.walking_sign();
    let inside = sign * (road.across(start.into()) - road.kerb(side));
    if inside >= 0.0 {
        let inside = Stated { value: inside, dimension: Dimension::LENGTH, of: StatedBy::Start };
        return Err(ModelError::stating(
            "`jaywalker` starts {} inside the kerb, but must start on the pavement",
            [inside],
            "start it 2 m from the kerb, as its source does",
        ));
    }
    if sign * road.across(goal.into()) <= sign * road.kerb(side) {
        return Err(ModelError::with_hint(
            "the goal of `jaywalker` is not across its kerb",
            "put the goal on the other side of the road",
        ));
    }
    let step = context.world.step;
    if !(STEPS.0..=STEPS.1).contains(&step) {
        let (low, high) = STEPS;
        let step = show_outside(step, STEPS);
        return Err(ModelError::with_hint(
            format!("`jaywalker` is made for steps of {low} .. {high} s, but the step is {step} s"),
            "take a step of 0.02 s",
        ));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::test_walk::Walk;
    use scenario::{Settings, Value};

    #[test]
    fn a_place_where_it_cannot_be_is_an_error_with_a_hint() {
        let refused = |change: fn(&mut Walk), part: &str| {
            let mut walk = Walk::new(&jaywalker(), Settings::default());
            change(&mut walk);
            let error = walk.rebuild(&jaywalker(), Settings::default()).expect_err(part);
            assert!(error.to_string().contains(part), "{error}");
            assert!(error.hint.is_some());
        };
        refused(|walk| walk.world.road.kerbs = false, "kerbs");
        refused(|walk| walk.world.pedestrians[0].start.y = -1.0, "1 m inside the kerb");
        refused(|walk| walk.world.pedestrians[0].goal.y = -3.0, "goal");
        refused(|walk| walk.world.step = 0.1, "0.1 s");
    }

    #[test]
    fn stop_times_must_be_in_order() {
        let given = Settings::from([("stop_time_min", Value::Number(2.0))]);
        assert!(Walk::try_new(&jaywalker(), given).err().unwrap().to_string().contains("stop_time_max"));
    }

    #[test]
    fn without_vehicles_it_walks_across_after_a_second() {
        let mut walk = Walk::new(&jaywalker(), Settings::default());
        walk.go(1.0);
        assert_eq!((walk.position().y, walk.pedestrian.mode()), (-4.0, "waiting".into()));
        walk.go(8.0);
        assert_eq!(walk.pedestrian.mode(), "finished");
        assert!((walk.position().y - 6.0).abs() < 0.2);
    }
}
