//! A reduced Autoware: how its stack reacts to pedestrians and the signal at a crossing, longitudinally.
//!
//! Tracker, decisions and profile run at the planning rate, the controller at its own; the `delay_lag` dynamics are
//! the vehicle. What it is and is not: docs/models/controller-autoware.md.

mod braking;
mod crossing;
mod debounce;
mod decision;
mod emergency_brake;
mod lane_stop;
mod longitudinal;
mod parameters;
mod phase;
mod profile;
mod site;
mod stack;
mod stop_position;
mod tracker;
mod traffic_light;

use super::{CommandKind, ControllerContext, ControllerModel};
use scenario::{Attention, Chance, Dimension, LooksAt, SignalConduct};
use sim::random::{Agent, Purpose, stream};
use sim::{Controller, ModelError, Stated, StatedBy};

/// The registry entry.
pub fn autoware() -> ControllerModel {
    let declaration = parameters::declaration();
    ControllerModel::new(declaration, CommandKind::Acceleration, build)
        .driving("delay_lag")
        .chance(Chance::If(|settings| settings.number("miss_probability") > 0.0))
        .signals(SignalConduct::Obeys)
        .attention(Attention::Reacts(|_| LooksAt::OWN_LANE))
}

fn build(context: &ControllerContext) -> Result<Box<dyn Controller>, ModelError> {
    let settings = context.settings;
    if !context.world.road_of(context.setup).other_crossings.is_empty() && settings.flag("crosswalk_mapped") {
        return Err(ModelError::with_hint(
            "`autoware` is given a map with one crosswalk, and the road has several crossings",
            "use `preset: lane_only`, or a road with one crossing",
        ));
    }
    let period = settings.number("planning_period");
    let shortest = settings.number("control_period").max(settings.number("vehicle_period"));
    if period < shortest {
        let calls = ["control_period", "vehicle_period"];
        let longer = calls.into_iter().find(|name| settings.number(name) == shortest).unwrap_or(calls[0]);
        let stated = |value, name: &'static str| Stated {
            value,
            dimension: Dimension::TIME,
            of: StatedBy::Setting(name.into()),
        };
        return Err(ModelError::stating(
            "`planning_period` of `autoware` is {}, but its calls are {} apart",
            [stated(period, "planning_period"), stated(shortest, longer)],
            "let it be at least the longer of `control_period` and `vehicle_period`",
        ));
    }
    let misses = stream(context.seed, Agent::Vehicle(context.rank), Purpose::Perception);
    let pedestrians = context.world.pedestrians.len();
    let map_has_signal = context.setup.obeys_signals;
    Ok(Box::new(stack::Stack::new(
        settings,
        context.setup.speed_at_start(),
        (pedestrians, misses),
        map_has_signal,
    )))
}
