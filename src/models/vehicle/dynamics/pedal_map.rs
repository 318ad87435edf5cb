//! What a car's acceleration is at a pedal position and a speed: maps of four cars of CARLA.
//!
//! Each car has a `law` (the straight-line fits of the reduced model) and, where there are measurements, a
//! `measured` map. Comments mark every row as measured or inferred. Accelerations in m/s², speeds in m/s.
//!
//! Sources: Prius, CARLA 0.9.15: accelerate and brake maps of `autoware_carla_interface`. Model 3, CARLA 0.9.12:
//! calibration data of `carla_autoware_bridge`. MKZ 2020, CARLA 0.9.15: kinematic fits of `carla_garage`.

/// Acceleration over pedal position and speed: straight lines in between, constant outside.
#[derive(Debug, Clone, Copy)]
pub struct Grid {
    /// Ascending.
    pub speeds: &'static [f64],
    /// Pedal positions, ascending from 0, each with one acceleration per speed.
    pub rows: &'static [(f64, &'static [f64])],
}

/// The two pedals of a car. Row 0 of both maps is coasting.
#[derive(Debug, Clone, Copy)]
pub struct PedalMap {
    pub throttle: Grid,
    pub brake: Grid,
}

impl Grid {
    /// m/s² at a pedal position (0..1) and a speed.
    pub fn acceleration(&self, pedal: f64, speed: f64) -> f64 {
        self.at(&locate(self.speeds, speed), pedal)
    }

    /// The same at a place among its speeds.
    fn at(&self, place: &Place, pedal: f64) -> f64 {
        let above = self.rows.iter().position(|&(position, _)| position >= pedal);
        match above {
            Some(0) => place.read(self.rows[0].1),
            Some(upper) => {
                let ((low, lower_row), (high, upper_row)) = (self.rows[upper - 1], self.rows[upper]);
                let share = (pedal - low) / (high - low);
                lerp(place.read(lower_row), place.read(upper_row), share)
            }
            None => place.read(self.rows[self.rows.len() - 1].1),
        }
    }

    /// The pedal position nearest to 0 that gives `wanted` m/s² at a speed; the end of its travel when none does.
    /// Accelerations must rise (or fall) with the pedal at every speed.
    pub fn pedal(&self, wanted: f64, speed: f64) -> f64 {
        let place = locate(self.speeds, speed);
        for pair in self.rows.windows(2) {
            let (start, end) = (place.read(pair[0].1), place.read(pair[1].1));
            if (start.min(end)..=start.max(end)).contains(&wanted) && start != end {
                return lerp(pair[0].0, pair[1].0, (wanted - start) / (end - start));
            }
        }
        let (first, last) = (self.rows[0], self.rows[self.rows.len() - 1]);
        let (start, end) = (place.read(first.1), place.read(last.1));
        if (wanted - start).abs() < (wanted - end).abs() { first.0 } else { last.0 }
    }
}

impl PedalMap {
    /// m/s² by the throttle alone, and with both pedals where they are, as while the one is released and the other pressed.
    pub fn accelerations(&self, throttle: f64, brake: f64, speed: f64) -> (f64, f64) {
        let place = locate(self.brake.speeds, speed);
        let coasting = self.brake.at(&place, 0.0);
        let braking = if brake == 0.0 { coasting } else { self.brake.at(&place, brake) };
        let driving = self.throttle.acceleration(throttle, speed);
        (driving + coasting - coasting, driving + braking - coasting)
    }
}

/// A place between two neighbours of an ascending list.
struct Place {
    lower: usize,
    upper: usize,
    share: f64,
}

impl Place {
    fn read(&self, values: &[f64]) -> f64 {
        lerp(values[self.lower], values[self.upper], self.share)
    }
}

fn locate(ascending: &[f64], value: f64) -> Place {
    match ascending.iter().position(|&entry| entry >= value) {
        Some(0) => Place { lower: 0, upper: 0, share: 0.0 },
        Some(upper) => {
            let (low, high) = (ascending[upper - 1], ascending[upper]);
            Place { lower: upper - 1, upper, share: (value - low) / (high - low) }
        }
        None => Place { lower: ascending.len() - 1, upper: ascending.len() - 1, share: 0.0 },
    }
}

fn lerp(from: f64, to: f64, share: f64) -> f64 {
    from + (to - from) * share
}

/// The rows of a law do not depend on speed.
const ANY: &[f64] = &[0.0];

/// Coasting -0.49, brake -3.4 per unit (fit of the measured rows from brake 0.2 on).
pub const PRIUS_LAW: PedalMap = PedalMap {
    throttle: Grid {
        speeds: ANY,
        rows: &[
            (0.0, &[-0.49]),
            (0.1, &[-0.25]), // measured near 8.3 m/s, as the rows up to 0.5
            (0.2, &[-0.10]),
            (0.3, &[0.78]),
            (0.4, &[1.58]),
            (0.5, &[2.17]),
            (0.75, &[3.0]), // inferred: the table ends near 0.5
        ],
    },
    brake: Grid { speeds: ANY, rows: &[(0.0, &[-0.49]), (1.0, &[-3.89])] },
};

/// Speeds of the Prius' rows.
const PRIUS_SPEEDS: &[f64] = &[0.0, 1.4, 2.8, 4.2, 5.6, 6.9, 8.3];

pub const PRIUS_MEASURED: PedalMap = PedalMap {
    throttle: Grid {
        speeds: &[0.0, 8.3],
        rows: &[
            (0.0, &[-0.20, -0.49]), // at rest inferred from 1.4 m/s
            (0.1, &[0.45, -0.25]),  // at rest inferred: on the line from coasting to 0.3
            (0.2, &[1.10, -0.10]),  // at rest inferred, as 0.1
            (0.3, &[1.75, 0.78]),   // measured
            (0.4, &[2.65, 1.58]),   // measured
            (0.5, &[3.30, 2.17]),   // measured
            (0.75, &[4.13, 3.0]),   // inferred: 0.83 above 0.5 at rest as at 8.3 m/s
        ],
    },
    brake: Grid {
        speeds: PRIUS_SPEEDS,
        rows: &[
            (0.0, &[-0.20, -0.20, -0.49, -0.49, -0.49, -0.49, -0.49]), // measured, at rest inferred
            (0.1, &[-0.22, -0.25, -0.54, -0.54, -0.54, -0.54, -0.54]), // 8.3 m/s measured, below inferred
            (0.2, &[-0.50, -0.55, -0.80, -0.83, -0.85, -0.86, -0.87]), // 8.3 m/s measured, below inferred
            (0.3, &[-1.00, -1.04, -1.48, -1.55, -1.57, -1.59, -1.61]), // measured
            (0.4, &[-1.48, -1.50, -1.85, -2.05, -2.10, -2.10, -2.10]), // 8.3 m/s measured, below inferred
            (0.5, &[-1.49, -1.51, -1.86, -2.06, -2.11, -2.11, -2.11]), // measured (looks filled in by hand)
            (0.8, &[-2.08, -2.11, -2.60, -2.88, -2.95, -2.95, -2.95]), // 8.3 m/s measured, below as row 0.5
            (1.0, &[-2.65, -2.68, -3.31, -3.66, -3.75, -3.75, -3.75]), // inferred: extrapolated to 3.5..4
        ],
    },
};

/// Coasting -0.34 per m/s (engine damping), brake -5.25 per unit; both fitted.
pub const MODEL3_LAW: PedalMap = PedalMap {
    throttle: Grid {
        speeds: &[0.0, 100.0],
        rows: &[
            (0.0, &[0.0, -34.0]), // the fitted coasting
            (0.5, &[0.76, 0.76]), // measured near 8.3 m/s, as the rows below
            (0.6, &[0.98, 0.98]),
            (0.7, &[2.12, 2.12]),
            (0.75, &[2.36, 2.36]),
            (0.8, &[2.60, 2.60]),
        ],
    },
    brake: Grid { speeds: &[0.0, 100.0], rows: &[(0.0, &[0.0, -34.0]), (1.0, &[-5.25, -39.25])] },
};

const MODEL3_SPEEDS: &[f64] = &[0.0, 1.4, 2.8, 4.2, 5.6, 6.9, 8.3, 9.7, 11.1];

pub const MODEL3_MEASURED: PedalMap = PedalMap {
    throttle: Grid {
        speeds: MODEL3_SPEEDS,
        rows: &[
            (0.0, &[0.0, -0.61, -0.87, -1.48, -2.05, -2.55, -2.80, -3.30, -3.60]), // measured, at rest inferred
            (0.5, &[0.76; 9]), // measured near 8.3 m/s, as the rows below; other speeds inferred
            (0.6, &[0.98; 9]),
            (0.7, &[2.12; 9]),
            (0.75, &[2.36; 9]),
            (0.8, &[2.60; 9]),
        ],
    },
    brake: Grid {
        speeds: MODEL3_SPEEDS,
        rows: &[
            (0.0, &[0.0, -0.61, -0.87, -1.48, -2.05, -2.55, -2.80, -3.30, -3.60]), // measured, at rest inferred
            // 8.3 m/s measured; elsewhere inferred, as far between the rows 0 and 0.5 as at 8.3 m/s.
            (0.1, &[-0.72, -1.29, -1.50, -2.07, -2.60, -3.01, -3.30, -3.80, -4.10]),
            (0.2, &[-1.43, -1.96, -2.13, -2.66, -3.144, -3.47, -3.80, -4.30, -4.60]),
            (0.3, &[-2.22, -2.71, -2.82, -3.30, -3.75, -3.98, -4.35, -4.85, -5.15]),
            (0.4, &[-2.70, -3.15, -3.23, -3.69, -4.11, -4.28, -4.68, -5.18, -5.48]),
            (0.5, &[-3.80, -3.80, -4.20, -4.60, -4.95, -5.00, -5.45, -5.95, -6.25]), // measured 1.4..9.7 m/s
            (0.8, &[-5.35, -5.35, -5.75, -6.15, -6.50, -6.55, -7.00, -7.50, -7.80]), // 8.3 m/s measured
            (1.0, &[-6.40, -6.40, -6.80, -7.20, -7.55, -7.60, -8.05, -8.55, -8.85]), // inferred: extrapolated
        ],
    },
};

/// Coasting -1.4 (inferred), brake -7.9 per unit through the measured full brake at 30 km/h.
pub const MKZ2020_LAW: PedalMap = PedalMap {
    throttle: Grid {
        speeds: ANY,
        rows: &[
            (0.0, &[-1.4]),  // inferred
            (0.3, &[-1.35]), // measured near 8.3 m/s, as the rows below
            (0.4, &[-0.48]),
            (0.5, &[0.43]),
            (0.75, &[2.81]),
            (1.0, &[5.35]),
        ],
    },
    brake: Grid { speeds: ANY, rows: &[(0.0, &[-1.4]), (1.0, &[-9.3])] },
};

pub const MKZ2020_MEASURED: PedalMap = PedalMap {
    throttle: MKZ2020_LAW.throttle,
    brake: Grid {
        // 10, 20, 30, 35 and 40 km/h.
        speeds: &[10.0 / 3.6, 20.0 / 3.6, 30.0 / 3.6, 35.0 / 3.6, 40.0 / 3.6],
        rows: &[
            (0.0, &[-1.4; 5]),                        // inferred, and linear from here to full brake
            (1.0, &[-22.6, -16.6, -9.3, -7.5, -6.9]), // measured
        ],
    },
};

/// A car between the measured ones; nothing measured.
pub const GENERIC_LAW: PedalMap = PedalMap {
    throttle: Grid {
        speeds: ANY,
        rows: &[
            (0.0, &[-0.5]),
            (0.3, &[0.0]),
            (0.75, &[2.4]),
            (1.0, &[2.4 / 0.45 * 0.7]), // the line from 0.3 through 0.75 goes on
        ],
    },
    brake: Grid { speeds: ANY, rows: &[(0.0, &[-0.5]), (1.0, &[-8.5])] },
};

#[cfg(test)]
mod tests {
    use super::*;

    const MAPS: [(&str, PedalMap); 7] = [
        ("prius law", PRIUS_LAW),
        ("prius measured", PRIUS_MEASURED),
        ("model3 law", MODEL3_LAW),
        ("model3 measured", MODEL3_MEASURED),
        ("mkz2020 law", MKZ2020_LAW),
        ("mkz2020 measured", MKZ2020_MEASURED),
        ("generic law", GENERIC_LAW),
    ];

    #[test]
    fn pedals_act_monotonically_and_maps_invert() {
        for (name, map) in MAPS {
            for speed in (0..=60).map(|k| f64::from(k) * 0.25) {
                let coasting = map.brake.acceleration(0.0, speed);
                assert!((map.throttle.acceleration(0.0, speed) - coasting).abs() < 0.3, "{name} {speed}");
                for (grid, sign) in [(map.throttle, 1.0), (map.brake, -1.0)] {
                    let last = grid.rows[grid.rows.len() - 1].0;
                    for k in 1..=100 {
                        let (before, pedal) = (last * f64::from(k - 1) / 100.0, last * f64::from(k) / 100.0);
                        let here = grid.acceleration(pedal, speed);
                        assert!(
                            sign * (here - grid.acceleration(before, speed)) > 0.0,
                            "{name} {speed} {pedal}"
                        );
                        assert!((grid.pedal(here, speed) - pedal).abs() < 1e-9, "{name} {speed} {pedal}");
                    }
                }
            }
        }
    }

    #[test]
    fn hold_throttles() {
        let hold = |map: PedalMap| map.throttle.pedal(0.0, 30.0 / 3.6);
        assert!((hold(PRIUS_LAW) - 0.21).abs() < 0.005);
        assert!((0.39..=0.40).contains(&hold(MODEL3_LAW)));
        assert!((hold(MKZ2020_LAW) - 0.45).abs() < 0.005);
        assert!((hold(GENERIC_LAW) - 0.30).abs() < 1e-12);
    }

    #[test]
    fn laws_give_the_stated_brakes_at_cruise_speed() {
        let brake = |map: PedalMap, pedal| map.brake.acceleration(pedal, 30.0 / 3.6);
        for (pedal, expected) in [(0.3, -2.9), (0.5, -4.5), (1.0, -8.5)] {
            assert!((brake(GENERIC_LAW, pedal) - expected).abs() < 1e-9);
        }
        // The fits against the measured rows at 8.33 m/s.
        for (pedal, measured) in [(0.2, -0.87), (0.3, -1.61), (0.4, -2.10), (0.5, -2.11)] {
            assert!((brake(PRIUS_LAW, pedal) - measured).abs() < 0.31, "{pedal}");
        }
        for (pedal, measured) in
            [(0.1, -3.3), (0.2, -3.8), (0.3, -4.35), (0.4, -4.68), (0.5, -5.45), (0.8, -7.0)]
        {
            assert!((brake(MODEL3_LAW, pedal) - measured).abs() < 0.27, "{pedal}");
        }
        assert!((brake(MKZ2020_LAW, 1.0) + 9.3).abs() < 1e-12);
    }

    #[test]
    fn only_the_prius_stays_below_a_sudden_change_at_half_brake() {
        let at_half = |map: PedalMap| -map.brake.acceleration(0.5, 30.0 / 3.6);
        assert!(at_half(PRIUS_LAW) < 2.5 && at_half(PRIUS_MEASURED) < 2.5);
        assert!(
            [MODEL3_LAW, MODEL3_MEASURED, MKZ2020_LAW, MKZ2020_MEASURED]
                .map(at_half)
                .iter()
                .all(|a| *a > 2.5)
        );
    }
}
