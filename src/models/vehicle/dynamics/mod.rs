//! Longitudinal dynamics: how a vehicle answers its controller, one file a kind.

mod delay_lag;
mod ideal;
mod motion;
mod pedal_car;
mod pedal_map;

pub use delay_lag::delay_lag;
pub use ideal::ideal;
pub use pedal_car::{generic, mkz2020, model3, prius};

#[cfg(test)]
pub(super) mod tests {
    use crate::vehicle::DynamicsModel;
    use scenario::Settings;
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
}
