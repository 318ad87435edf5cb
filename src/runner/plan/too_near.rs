//! People who begin their way where waiting is not an option for their model, in words.

use super::places::metres as shown;
use scenario::World;
use sim::TooNear;

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
        metres(found.distance.abs()),
        world.vehicles[found.vehicle].name,
        setup.model.model,
        metres(found.needed)
    )
}

/// To a millimetre.
pub fn metres(length: f64) -> String {
    shown((length * 1e3).round() / 1e3)
}
