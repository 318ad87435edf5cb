//! What a vehicle's controller was told of others and was not so, in words.

use crate::format::with_unit;
use scenario::{Dimension, World};
use sim::{PerceivedOther, PerceivedView};

/// Such as `av perceives walker 0.36 m from where they are, moving at 1.2 m/s, 0.3 s late`, for each of those whom it was told so of.
pub fn perceived_words<'a>(world: &'a World, view: &'a PerceivedView) -> impl Iterator<Item = String> + 'a {
    let late = match view.age {
        Some(age) if hundredths(age) > 0.0 => {
            format!(", {} late", with_unit(hundredths(age), Dimension::TIME))
        }
        _ => String::new(),
    };
    view.others.iter().filter_map(move |PerceivedOther { who, off, speed, .. }| {
        let (car, other) = (road_user(world, view.vehicle)?, road_user(world, *who)?);
        let off = with_unit(hundredths(*off), Dimension::LENGTH);
        let speed = with_unit(hundredths(*speed), Dimension::SPEED);
        Some(format!("{car} perceives {other} {off} from where they are, moving at {speed}{late}"))
    })
}

/// The name of a road user by its index, vehicles first; what was read may name one that there is not.
pub fn road_user(world: &World, index: usize) -> Option<&str> {
    let cars = world.vehicles.iter().map(|car| &*car.name);
    cars.chain(world.pedestrians.iter().map(|person| &*person.name)).nth(index)
}

fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}
