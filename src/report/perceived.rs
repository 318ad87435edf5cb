//! What a vehicle's controller was told of others and was not so, in words.

use crate::format::with_unit;
use scenario::{Dimension, World};
use sim::{PerceivedOther, PerceivedView};

/// Such as `av perceives walker 0.36 m from where they are, moving at 1.2 m/s, 0.3 s late`, for each of those whom it was told so of.
pub fn perceived_words<'a>(world: &'a World, view: &'a PerceivedView) -> impl Iterator<Item = String> + 'a {
    let names: Vec<&str> = world.vehicles.iter().map(|car| &*car.name).collect();
    let names = names.into_iter().chain(world.pedestrians.iter().map(|person| &*person.name));
    let names: Vec<&str> = names.collect();
    let late = match view.age {
        Some(age) if hundredths(age) > 0.0 => {
            format!(", {} late", with_unit(hundredths(age), Dimension::TIME))
        }
        _ => String::new(),
    };
    view.others.iter().filter_map(move |PerceivedOther { who, off, speed, .. }| {
        let (car, other) = (names.get(view.vehicle)?, names.get(*who)?);
        let off = with_unit(hundredths(*off), Dimension::LENGTH);
        let speed = with_unit(hundredths(*speed), Dimension::SPEED);
        Some(format!("{car} perceives {other} {off} from where they are, moving at {speed}{late}"))
    })
}

fn hundredths(value: f64) -> f64 {
    (value * 100.0).round() / 100.0
}
