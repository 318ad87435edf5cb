//! Pedestrians that begin their way where waiting is not an option for their model: the nearest of many runs, in words.

use super::places::metres;
use scenario::World;
use sim::{TooNear, too_near};

/// A place from which a pedestrian sets out too near to a lane, as it is in several worlds.
pub struct NearestStart {
    /// Where it is nearest.
    pub found: TooNear,
    /// The index of the world in which it is.
    pub world: usize,
    /// In how many worlds it is too near.
    pub times: usize,
}

/// Every place from which a pedestrian sets out too near to a lane in any of these worlds.
pub fn nearest_starts<'w>(worlds: impl IntoIterator<Item = &'w World>) -> Vec<NearestStart> {
    let mut starts: Vec<NearestStart> = Vec::new();
    for (world, found) in worlds
        .into_iter()
        .enumerate()
        .flat_map(|(index, world)| too_near(world).into_iter().map(move |found| (index, found)))
    {
        let place = (found.pedestrian, found.refuge);
        match starts.iter_mut().find(|known| (known.found.pedestrian, known.found.refuge) == place) {
            None => starts.push(NearestStart { found, world, times: 1 }),
            Some(known) => {
                known.times += 1;
                if found.missing() > known.found.missing() {
                    (known.found, known.world) = (found, world);
                }
            }
        }
    }
    starts
}

/// Such as "pedestrian `walker` starts 2 m from the centre of the lane of `av`, and `commotions` cannot wait nearer than 2.15 m".
pub fn too_near_words(world: &World, found: &TooNear) -> String {
    let setup = &world.pedestrians[found.pedestrian];
    let sets_out = match found.refuge {
        0 => "starts",
        _ => "goes on from a refuge",
    };
    format!(
        "{} `{}` {sets_out} {} from the centre of the lane of `{}`, and `{}` cannot wait nearer than {}",
        setup.kind.word(),
        setup.name,
        to_a_millimetre(found.distance.abs()),
        world.vehicles[found.vehicle].name,
        setup.model.model,
        to_a_millimetre(found.needed)
    )
}

/// A length (m) to a millimetre.
pub fn to_a_millimetre(length: f64) -> String {
    metres((length * 1e3).round() / 1e3)
}
