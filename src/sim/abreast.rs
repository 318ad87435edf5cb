//! Where pedestrians lie, seen from vehicles whose paths bend: worked out once for whoever decides and whoever measures.

use nalgebra::Vector2;

use scenario::{Located, Path, World};

/// Where each pedestrian was the last time, and where that lies seen from the path of each vehicle that bends.
#[derive(Debug, Clone, Default)]
pub struct Abreast {
    /// Vehicle by vehicle; nobody for one whose path does not bend.
    of: Vec<Vec<Option<(Vector2<f64>, Located)>>>,
}

impl Abreast {
    /// Of a run that has not begun.
    pub(super) fn new(world: &World) -> Self {
        let of = |path: Path| vec![None; if path.course().is_some() { world.pedestrians.len() } else { 0 }];
        Self { of: world.vehicles.iter().map(|setup| of(world.path_of(setup))).collect() }
    }

    /// Where somebody lies, seen from the path of a vehicle: who stands is abreast of the same place.
    pub(super) fn locate(
        &mut self,
        vehicle: usize,
        path: &Path,
        pedestrian: usize,
        position: Vector2<f64>,
    ) -> Located {
        let Some(last) = self.of[vehicle].get_mut(pedestrian) else { return path.locate(position) };
        let known = last.filter(|(known, _)| *known == position);
        last.insert(known.unwrap_or_else(|| (position, path.locate(position)))).1
    }

    /// The same where that was asked for before.
    pub fn known(&self, vehicle: usize, pedestrian: usize, position: Vector2<f64>) -> Option<Located> {
        let (known, located) = (*self.of.get(vehicle)?.get(pedestrian)?)?;
        (known == position).then_some(located)
    }

    /// Whether the path of no vehicle bends.
    pub(super) fn is_empty(&self) -> bool {
        self.of.iter().all(Vec::is_empty)
    }
}
