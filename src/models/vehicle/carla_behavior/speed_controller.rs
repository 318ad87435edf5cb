//! CARLA's longitudinal PID with its short memory of errors.

use std::collections::VecDeque;

use sim::Command;

/// PID on the speed error in km/h; the output is one pedal or the other.
pub struct SpeedController {
    proportional: f64,
    integral: f64,
    derivative: f64,
    period: f64,
    max_throttle: f64,
    max_brake: f64,
    /// The last errors, the newest last; its capacity is the memory.
    errors: VecDeque<f64>,
    memory: usize,
}

impl SpeedController {
    /// `gains`: proportional, integral and derivative, per km/h; `memory` is a number of errors, `period` in s.
    pub fn new(gains: [f64; 3], memory: usize, period: f64, max_throttle: f64, max_brake: f64) -> Self {
        let [proportional, integral, derivative] = gains;
        let errors = VecDeque::with_capacity(memory);
        Self { proportional, integral, derivative, period, max_throttle, max_brake, errors, memory }
    }

    /// The pedals for an error (wanted minus own speed) in km/h.
    pub fn pedals(&mut self, error: f64) -> Command {
        if self.errors.len() == self.memory {
            self.errors.pop_front();
        }
        let last = self.errors.back().copied();
        self.errors.push_back(error);
        let (sum, change) = match last {
            Some(last) if self.errors.len() >= 2 => {
                (self.errors.iter().sum::<f64>() * self.period, (error - last) / self.period)
            }
            _ => (0.0, 0.0),
        };
        let output =
            (self.proportional * error + self.integral * sum + self.derivative * change).clamp(-1.0, 1.0);
        if output >= 0.0 {
            Command::Pedals { throttle: output.min(self.max_throttle), brake: 0.0 }
        } else {
            Command::Pedals { throttle: 0.0, brake: (-output).min(self.max_brake) }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stock() -> SpeedController {
        SpeedController::new([1.0, 0.05, 0.0], 10, 0.05, 0.75, 0.3)
    }

    fn throttle(command: Command) -> f64 {
        match command {
            Command::Pedals { throttle, brake } => throttle - brake,
            Command::Acceleration(_) => unreachable!(),
        }
    }

    #[test]
    fn saturates_at_three_quarters_and_three_tenths() {
        assert_eq!(throttle(stock().pedals(0.8)), 0.75);
        assert_eq!(throttle(stock().pedals(0.5)), 0.5);
        assert_eq!(throttle(stock().pedals(-0.2)), -0.2);
        assert_eq!(throttle(stock().pedals(-5.0)), -0.3);
    }

    #[test]
    fn the_integral_adds_at_most_a_fortieth_of_a_constant_error() {
        let mut controller = stock();
        let outputs: Vec<_> = (0..20).map(|_| throttle(controller.pedals(0.4))).collect();
        assert_eq!(outputs[0], 0.4);
        assert!((outputs[1] - 0.4 * (1.0 + 2.0 * 0.05 * 0.05)).abs() < 1e-12);
        assert!((outputs[9] - 0.4 * 1.025).abs() < 1e-12 && (outputs[19] - 0.4 * 1.025).abs() < 1e-12);
    }

    #[test]
    fn the_derivative_looks_at_the_last_two_errors() {
        let mut controller = SpeedController::new([0.0, 0.0, 0.1], 10, 0.05, 1.0, 1.0);
        assert_eq!(throttle(controller.pedals(0.3)), 0.0);
        assert!((throttle(controller.pedals(0.4)) - 0.2).abs() < 1e-12);
    }
}
