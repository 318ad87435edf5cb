//! Longitudinal dynamics: how a vehicle answers its controller, one file a kind.

mod delay_lag;
mod ideal;
mod pedal_car;
mod pedal_map;

pub use delay_lag::delay_lag;
pub use ideal::ideal;
pub use pedal_car::{generic, mkz2020, model3, prius};

#[cfg(test)]
pub(super) mod tests {
    use crate::vehicle::DynamicsModel;
    use scenario::{Ground, Settings};
    use sim::{Command, Dynamics, Longitudinal};

    /// A vehicle at 30 km/h.
    pub fn cruising() -> Longitudinal {
        Longitudinal { travelled: 0.0, speed: 30.0 / 3.6, acceleration: 0.0 }
    }

    pub fn built(model: &DynamicsModel, settings: Settings) -> Box<dyn Dynamics> {
        (model.build)(&model.declaration.resolve(&settings).unwrap()).unwrap()
    }

    /// Distance (m) and time (s) to standstill under a constant command.
    pub fn stop(dynamics: &mut dyn Dynamics, command: Command, step: f64) -> (f64, f64) {
        let mut motion = cruising();
        let mut time = 0.0;
        while motion.speed > 0.0 && time < 60.0 {
            dynamics.advance(&mut motion, command, step);
            time += step;
        }
        (motion.travelled, time)
    }

    /// Dynamics of which nobody says what they do on a road that is steep or slippery.
    struct Unsaid(Box<dyn Dynamics>);

    impl Dynamics for Unsaid {
        fn advance(&mut self, motion: &mut Longitudinal, command: Command, step: f64) {
            self.0.advance(motion, command, step);
        }
    }

    #[test]
    fn others_stop_on_it_as_ours_do() {
        let model = super::ideal();
        let grounds = [(0.0, 0.3), (0.08, 0.3), (-0.08, 0.5), (0.1, 1.5), (-0.1, 1.5)];
        for (gradient, friction) in grounds {
            let ground = Ground { gradient: Some(gradient), friction: Some(friction) };
            let stop = |mut car: Box<dyn Dynamics>| {
                let mut motion = cruising();
                for _ in 0..2000 {
                    car.advance_on(&ground, &mut motion, Command::Acceleration(-6.0), 0.025);
                }
                motion
            };
            let own = stop(built(&model, Settings::default()));
            let other = stop(Box::new(Unsaid(built(&model, Settings::default()))));
            let speed = 30.0 / 3.6;
            let way = speed * speed / (2.0 * (ground.grip().min(6.0) + ground.slope()));
            assert!((own.travelled - way).abs() < 1e-9, "{ground:?}: {own:?}, not {way}");
            assert!((other.travelled - way).abs() < 1e-9, "{ground:?}: {other:?}, not {way}");
            assert_eq!((own.speed, other.speed), (0.0, 0.0));
        }
    }
}
