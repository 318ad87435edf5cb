//! Where a vehicle's front hits somebody at a share of its width, whatever the angle at which their ways meet, and along bends.

use nalgebra::Vector2;

use super::geometry::{Footprint, apart, distance};
use super::start::waiting_outside;
use super::way::Way;
use scenario::agent::{PedestrianState, VehicleState};
use scenario::{CROSSES, PedestrianSetup, Shape};

/// The moment of a hit is looked for in steps of this, m, …
const LOOKS: f64 = 0.02;

/// … and found to this, m.
const CLOSE: f64 = 1e-12;

/// How far (m) the pedestrian has walked straight on from its start, and at which place (m) the vehicle's centre is, when the two first touch
/// and the pedestrian's reference point is at `share` of the vehicle's width, from the side that it comes from. `None` if their ways do not
/// cross.
pub fn hit_at(car: &VehicleState, setup: &PedestrianSetup, share: f64) -> Option<(f64, f64)> {
    let (whole, start) = (Way::new(setup), Vector2::from(setup.start));
    let way = whole.ahead(start);
    let met = car.path.met_between(start, Vector2::from(setup.goal))?;
    let met = car.path.along(met);
    // Both bodies fit between the place where the ways meet and this far from it.
    let reach = libm::hypot(car.length, car.width)
        + 2.0 * Footprint::from(&waiting_outside((setup, &whole))).radius();
    let mut car = car.clone();
    let mut person = PedestrianState { present: true, ..waiting_outside((setup, &whole)) };
    // How far it has walked where the vehicle is at a place, and the gap between the two then.
    let mut at = |place: f64| {
        car.motion.travelled = place;
        let (centre, ahead) = car.path.pose(place);
        let left = Vector2::new(-ahead.y, ahead.x);
        let sideways = way.dot(&left);
        let wanted = sideways.signum() * car.width * (share - 0.5);
        let walked = (wanted - (start + way * setup.reference - centre).dot(&left)) / sideways;
        person.position = start + way * walked;
        (sideways.abs() >= CROSSES).then(|| (walked, distance(&car, &person)))
    };
    let touching = first_touch(|place| at(place).map(|(_, gap)| gap), met, reach)?;
    Some((at(touching)?.0, touching))
}

/// A front that is so near to a body is what touches it, m.
const AT_THE_FRONT: f64 = 1e-6;

/// At which place (m) the vehicle's centre is when it first touches somebody who follows a course and has walked so far (m) along it, and at which share
/// of the vehicle's width their reference point is then, from the side of the road that they are on. `None` if they follow none, and if it
/// passes them or touches them with a flank.
pub fn hit_along(car: &VehicleState, setup: &PedestrianSetup, walked: f64) -> Option<(f64, f64)> {
    let course = setup.follows.as_ref()?;
    let whole = Way::new(setup);
    let position = course.point(course.along(setup.start.into()) + walked);
    let heading = whole.ahead(position);
    let person = PedestrianState { present: true, position, heading, ..waiting_outside((setup, &whole)) };
    let reach = libm::hypot(car.length, car.width) + 2.0 * Footprint::from(&person).radius();
    let mut driving = car.clone();
    let gap = |place: f64| {
        driving.motion.travelled = place;
        Some(distance(&driving, &person))
    };
    let touching = first_touch(gap, car.path.along(position), reach)?;
    let (centre, ahead) = car.path.pose(touching);
    let shape = Shape::Rectangle { length: 0.0, width: car.width };
    let front = Footprint { centre: centre + ahead * (car.length / 2.0), heading: ahead, shape };
    if apart(&front, &Footprint::from(&person)) > AT_THE_FRONT {
        return None;
    }
    let reference = position + heading * setup.reference;
    let side = setup.side.walking_sign() * car.path.locate(reference).far();
    Some((touching, 0.5 + side * ahead.perp(&(reference - centre)) / car.width))
}

/// The first place (m) within twice a reach (m) of a middle at which a gap is closed that was open before it; it is `None` where there is none.
fn first_touch(mut gap: impl FnMut(f64) -> Option<f64>, middle: f64, reach: f64) -> Option<f64> {
    let from = middle - 2.0 * reach;
    let looks = (4.0 * reach / LOOKS).ceil() as usize;
    let (mut apart, mut touching) = (None, None);
    for look in 0..=looks {
        let place = from + look as f64 * LOOKS;
        match gap(place) {
            Some(gap) if gap > 0.0 => apart = Some(place),
            Some(_) if apart.is_some() => {
                touching = Some(place);
                break;
            }
            _ => {}
        }
    }
    let (mut apart, mut touching) = (apart?, touching?);
    while touching - apart > CLOSE * (1.0 + touching.abs()) {
        let middle = (apart + touching) / 2.0;
        if middle <= apart || middle >= touching {
            break;
        }
        match gap(middle) {
            Some(gap) if gap <= 0.0 => touching = middle,
            _ => apart = middle,
        }
    }
    Some(touching)
}
