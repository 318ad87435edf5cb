//! Where a vehicle's front hits somebody at a share of its width, whatever the angle at which their ways meet.

use nalgebra::Vector2;

use super::geometry::{Footprint, distance};
use super::start::waiting_outside;
use super::way::Way;
use scenario::agent::{PedestrianState, VehicleState};
use scenario::{CROSSES, PedestrianSetup};

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
    let from = met - 2.0 * reach;
    let looks = (4.0 * reach / LOOKS).ceil() as usize;
    let (mut apart, mut touching) = (None, None);
    for look in 0..=looks {
        let place = from + look as f64 * LOOKS;
        match at(place) {
            Some((_, gap)) if gap > 0.0 => apart = Some(place),
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
        match at(middle) {
            Some((_, gap)) if gap <= 0.0 => touching = middle,
            _ => apart = middle,
        }
    }
    Some((at(touching)?.0, touching))
}
