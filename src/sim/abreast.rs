//! Where pedestrians lie, seen from vehicles whose paths bend: worked out once for whoever decides and whoever measures.

use nalgebra::Vector2;

use scenario::{Located, Path, World};

/// Where each pedestrian was the last time, and where that lies seen from the path of each vehicle that bends.
#[derive(Debug, Clone, Default)]
pub struct Abreast {
    /// Vehicle by vehicle; nobody for one whose path does not bend.
    of: Vec<Vec<Option<Last>>>,
}

/// Where somebody was (world frame, m), and where that lies.
#[derive(Debug, Clone, Copy)]
struct Last {
    position: Vector2<f64>,
    located: Located,
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
        let known = last.filter(|known| known.position == position);
        last.insert(known.unwrap_or_else(|| Last { position, located: path.locate(position) })).located
    }

    /// The same where that was asked for before.
    pub fn known(&self, vehicle: usize, pedestrian: usize, position: Vector2<f64>) -> Option<Located> {
        let last = (*self.of.get(vehicle)?.get(pedestrian)?)?;
        (last.position == position).then_some(last.located)
    }

    /// Whether the path of no vehicle bends.
    pub(super) fn is_empty(&self) -> bool {
        self.of.iter().all(Vec::is_empty)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use scenario::Bend;
    use scenario::geometry::{Piece, Pose, ReferenceLine};

    use super::*;
    use crate::fixture;

    #[test]
    fn who_has_moved_is_not_known_and_straight_paths_are_not_asked_for() {
        let straight = fixture::world();
        assert!(Abreast::new(&straight).is_empty());
        let mut world = straight;
        let line = ReferenceLine::new(Pose::origin(), &[Piece::arc(40.0, 2.0)]).unwrap();
        world.road.bend = Some(Bend { line: Arc::new(line), crossing: 30.0 });
        let (mut abreast, path) = (Abreast::new(&world), world.path_of(&world.vehicles[0]));
        let (here, there) = (Vector2::new(20.0, 3.0), Vector2::new(20.0, 3.1));
        assert!(!abreast.is_empty() && abreast.known(0, 0, here).is_none());
        for place in [here, there, there] {
            assert_eq!(abreast.locate(0, &path, 0, place), path.locate(place));
            assert_eq!(abreast.known(0, 0, place), Some(path.locate(place)));
        }
        assert!(abreast.known(0, 0, here).is_none() && abreast.known(7, 0, there).is_none());
        assert!(abreast.known(0, 7, there).is_none());
    }
}
