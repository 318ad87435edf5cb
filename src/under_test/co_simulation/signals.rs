//! Signals of a run, from the rows in which the protocol tells what a vehicle sees.

use scenario::{NOBODY_AT, OBJECT, OBJECTS, SEEN};

use crate::wire::{KINDS, LANES, PEDESTRIANS, RUNS, VEHICLES};

/// The number of signals.
pub const COUNT: usize = SEEN.len() + OBJECTS * OBJECT.len();

/// Those before what is ahead, which are columns of a run, too.
const FROM_RUNS: usize = SEEN.len() - 3;

/// Where red and green are.
const SIGNAL: usize = 11;

/// Where the gradient is, amber and the stop line behind it.
const GRADIENT: usize = FROM_RUNS - 5;

/// Who is ahead.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Object {
    /// Between bumpers, m.
    gap: f64,
    /// Pedestrians before vehicles, then by number: which of two is nearer never depends on the order in which they were told.
    rank: (u8, f64),
    x: f64,
    y: f64,
    vx: f64,
    vy: f64,
    length: f64,
    width: f64,
    kind: f64,
}

/// The kind of a vehicle, behind those of people.
const VEHICLE: f64 = 4.0;

/// What is told of a run, as rows of doubles.
pub struct RunRows<'a> {
    pub run: &'a [f64],
    /// Of pedestrians, of all runs; of this one are those of `index`.
    pub pedestrians: &'a [f64],
    pub vehicles: &'a [f64],
    /// The run's place in the request.
    pub index: usize,
}

/// Every signal of a run, in SI units, in the order of [`scenario::input_signals`].
pub fn signals(rows: &RunRows) -> [f64; COUNT] {
    let run = rows.run;
    let mut all = [0.0; COUNT];
    all[0] = run[1];
    all[1..FROM_RUNS].copy_from_slice(&run[3..2 + FROM_RUNS]);
    if all[SIGNAL].is_nan() {
        // No signal keeps the vehicle from going.
        all[SIGNAL] = 1.0;
    }
    for number in all[GRADIENT..FROM_RUNS].iter_mut().filter(|number| number.is_nan()) {
        *number = 0.0;
    }
    let (speed, length, lane) = (all[3], all[5], all[7]);
    let mut ahead = objects(rows, length);
    ahead.sort_by(|one, other| {
        one.gap
            .total_cmp(&other.gap)
            .then(one.rank.0.cmp(&other.rank.0))
            .then(one.rank.1.total_cmp(&other.rank.1))
    });
    let in_lane = ahead.iter().find(|one| one.y.abs() < lane / 2.0);
    let (present, gap, closing) = in_lane.map_or((0.0, NOBODY_AT, 0.0), |one| (1.0, one.gap, speed - one.vx));
    all[FROM_RUNS..SEEN.len()].copy_from_slice(&[present, gap, closing]);
    for (index, place) in all[SEEN.len()..].chunks_exact_mut(OBJECT.len()).enumerate() {
        place.copy_from_slice(&match ahead.get(index) {
            Some(one) => [1.0, one.x, one.y, one.vx, one.vy, one.length, one.width, one.kind],
            None => [0.0, NOBODY_AT, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        });
    }
    all
}

/// Those of a run whose centre is ahead of the vehicle's.
fn objects(rows: &RunRows, length: f64) -> Vec<Object> {
    let RunRows { pedestrians, vehicles, index, .. } = *rows;
    let object = |rank: u8, row: &[f64], size: usize, kind: f64| {
        let (x, its) = (row[2], row[size]);
        let (rank, gap) = ((rank, row[1]), x - (length + its) / 2.0);
        Object { gap, rank, x, y: row[3], vx: row[4], vy: row[5], length: its, width: row[size + 1], kind }
    };
    let of = |row: &&[f64]| row[0] == index as f64 && row[2] > 0.0;
    let people = pedestrians
        .chunks_exact(PEDESTRIANS.len() + KINDS.len())
        .filter(of)
        .map(|row| object(0, row, 8, row[PEDESTRIANS.len()]));
    let cars = vehicles.chunks_exact(VEHICLES.len()).filter(of).map(|row| object(1, row, 6, VEHICLE));
    people.chain(cars).collect()
}

const _: () = assert!(RUNS.len() + LANES.len() == 2 + FROM_RUNS);

#[cfg(test)]
mod tests {
    use scenario::input_signals;

    use super::*;

    fn of(run: &[f64], pedestrians: &[f64], vehicles: &[f64]) -> impl Fn(&str) -> f64 {
        let all = signals(&RunRows { run, pedestrians, vehicles, index: 1 });
        move |name| all[input_signals().position(|(known, _)| known == name).unwrap()]
    }

    /// A column of runs holds its own place.
    fn run() -> Vec<f64> {
        (0..RUNS.len() + LANES.len()).map(|place| place as f64).collect()
    }

    #[test]
    fn what_runs_are_told_is_told_by_the_same_name() {
        let run = run();
        let signal = of(&run, &[], &[]);
        for (place, column) in
            RUNS.iter().chain(&LANES).enumerate().filter(|(_, column)| !["slot", "new"].contains(column))
        {
            let group = input_signals().map(|(name, _)| name).find(|name| {
                name == column || *name == format!("ego.{column}") || *name == format!("road.{column}")
            });
            assert_eq!(
                signal(&group.unwrap_or_else(|| panic!("no signal {column}"))),
                place as f64,
                "{column}"
            );
        }
        assert_eq!(input_signals().count(), COUNT);
    }

    #[test]
    fn where_there_is_no_signal_nothing_is_red() {
        let mut run = run();
        run[13] = f64::NAN;
        assert_eq!(of(&run, &[], &[])("road.signal"), 1.0);
    }

    #[test]
    fn a_road_that_says_no_gradient_is_level() {
        let mut run = run();
        run[18..21].fill(f64::NAN);
        let signal = of(&run, &[], &[]);
        assert_eq!(["road.gradient", "road.amber", "road.stop_line"].map(signal), [0.0; 3]);
    }

    #[test]
    fn nobody_is_far_away() {
        let run = run();
        let signal = of(&run, &[], &[]);
        assert_eq!(
            (signal("ahead.present"), signal("ahead.gap"), signal("ahead.closing_speed")),
            (0.0, 1000.0, 0.0)
        );
        assert_eq!(
            (signal("object1.present"), signal("object8.x"), signal("object8.width")),
            (0.0, 1000.0, 0.0)
        );
    }

    #[test]
    fn those_ahead_are_told_nearest_first_whatever_their_order() {
        let (mut run, width) = (run(), PEDESTRIANS.len() + KINDS.len());
        // Speed, length and lane: 10 m/s, 4 m, 4 m.
        (run[5], run[7], run[9]) = (10.0, 4.0, 4.0);
        let mut pedestrians = Vec::new();
        for (row, id, x, y, vx, kind) in [
            (1.0, 7.0, 20.0, 1.0, 2.0, 1.0),
            (1.0, 3.0, 12.0, 3.0, 0.0, 2.0),
            (0.0, 1.0, 5.0, 0.0, 0.0, 1.0),
            (1.0, 2.0, -3.0, 0.0, 0.0, 3.0),
        ] {
            pedestrians.extend([row, id, x, y, vx, 0.5, 0.0, 0.0, 1.0, 0.5, kind]);
        }
        // The bumper of a long one is nearer than its centre.
        let vehicles = [1.0, 0.0, 22.0, -1.0, 8.0, 0.0, 10.0, 2.0];
        let told = of(&run, &pedestrians, &vehicles);
        assert_eq!((told("object1.x"), told("object1.y"), told("object1.length")), (12.0, 3.0, 1.0));
        assert_eq!((told("object2.x"), told("object2.vx"), told("object2.width")), (22.0, 8.0, 2.0));
        assert_eq!((told("object3.x"), told("object3.vy"), told("object4.present")), (20.0, 0.5, 0.0));
        assert_eq!([1, 2, 3, 4].map(|number| told(&format!("object{number}.kind"))), [2.0, 4.0, 1.0, 0.0]);
        // Who is at the side is not in the lane.
        assert_eq!((told("ahead.gap"), told("ahead.closing_speed")), (15.0, 2.0));
        let turned: Vec<f64> = pedestrians.chunks(width).rev().flatten().copied().collect();
        let rows = |pedestrians| signals(&RunRows { run: &run, pedestrians, vehicles: &vehicles, index: 1 });
        assert_eq!(rows(&pedestrians), rows(&turned));
    }
}
