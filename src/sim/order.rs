//! What somebody outside decides for a vehicle: a command, or speeds at times from then on.

use thiserror::Error;

use scenario::agent::Command;

/// What somebody outside decides.
#[derive(Debug, Clone, PartialEq)]
pub enum Order {
    /// Held until the next decision takes effect.
    Command(Command),
    /// Followed from the moment on at which it takes effect.
    Plan(Box<SpeedPlan>),
}

/// What somebody outside decides for a vehicle that may be steered as well.
#[derive(Debug, Clone, PartialEq)]
pub struct SteeredOrder {
    /// How fast it goes.
    pub along: Order,
    /// The curvature (1/m, to the left) of the way that its rear axle takes; `None`: it is not steered, as
    /// [`Controller::curvature`](scenario::agent::Controller::curvature) says.
    pub curvature: Option<f64>,
}

impl SteeredOrder {
    /// The numbers of its [`Order`], and the curvature (1/m) if there is one.
    pub fn values(&self) -> Vec<f64> {
        self.along.values().into_iter().chain(self.curvature).collect()
    }
}

impl From<Order> for SteeredOrder {
    fn from(along: Order) -> Self {
        Self { along, curvature: None }
    }
}

impl Order {
    /// Its numbers: an acceleration (m/s²); or throttle and brake; or times (s) and speeds (m/s) of a plan.
    pub fn values(&self) -> Vec<f64> {
        match self {
            Self::Command(Command::Acceleration(acceleration)) => vec![*acceleration],
            Self::Command(Command::Pedals { throttle, brake }) => vec![*throttle, *brake],
            Self::Plan(plan) => plan.0.iter().flat_map(|(time, speed)| [*time, *speed]).collect(),
        }
    }
}

/// The most points that a plan has.
pub const LONGEST_PLAN: usize = 16;

/// What following a speed asks for, m/s²: comfortable upwards, an emergency downwards.
const LIMITS: (f64, f64) = (-8.0, 3.0);

/// How fast a vehicle that is off its plan comes back to it, 1/s.
const GAIN: f64 = 1.0;

/// No speed is to be reached in a shorter time, s.
const SHORTEST: f64 = 0.2;

/// Speeds at times from now on. Between two points the speed is linear, before the first and after the last it is theirs.
#[derive(Debug, Clone, PartialEq)]
pub struct SpeedPlan(Vec<(f64, f64)>);

/// Why points are no plan.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum SpeedPlanError {
    #[error("the plan has no points")]
    /// No points.
    Empty,
    #[error("the plan has {0} points, more than {LONGEST_PLAN}")]
    /// That many points.
    TooLong(usize),
    #[error("the plan's times do not rise: {0} s after {1} s")]
    /// A time (s) after another one that is not before it.
    NotAscending(f64, f64),
    #[error("the plan has the speed {0} m/s, outside 0 .. 100 m/s")]
    /// m/s
    Speed(f64),
    #[error("the plan has the time {0} s")]
    /// s
    Time(f64),
}

impl SpeedPlan {
    /// Times (s, from now on) and speeds (m/s).
    ///
    /// # Errors
    /// Times that do not rise or are negative, speeds that no vehicle has, none or too many points.
    pub fn new(points: Vec<(f64, f64)>) -> Result<Self, SpeedPlanError> {
        if points.is_empty() {
            return Err(SpeedPlanError::Empty);
        }
        if points.len() > LONGEST_PLAN {
            return Err(SpeedPlanError::TooLong(points.len()));
        }
        for (time, speed) in &points {
            if !(0.0..=1e6).contains(time) {
                return Err(SpeedPlanError::Time(*time));
            }
            if !(0.0..=100.0).contains(speed) {
                return Err(SpeedPlanError::Speed(*speed));
            }
        }
        match points.windows(2).find(|pair| pair[1].0 <= pair[0].0) {
            Some(pair) => Err(SpeedPlanError::NotAscending(pair[1].0, pair[0].0)),
            None => Ok(Self(points)),
        }
    }

    /// Times (s) and speeds (m/s).
    pub fn points(&self) -> &[(f64, f64)] {
        &self.0
    }

    /// Speed (m/s) and its slope (m/s²) at a time after its beginning (s).
    fn at(&self, time: f64) -> (f64, f64) {
        let next = self.0.partition_point(|(point, _)| *point <= time);
        match (next.checked_sub(1).map(|last| self.0[last]), self.0.get(next).copied()) {
            (Some((from, start)), Some((to, end))) => {
                let slope = (end - start) / (to - from);
                (start + slope * (time - from), slope)
            }
            (Some((_, speed)), None) | (None, Some((_, speed))) => (speed, 0.0),
            (None, None) => (0.0, 0.0),
        }
    }

    /// What a vehicle with that speed (m/s) does to follow it, m/s².
    pub fn acceleration(&self, time: f64, speed: f64) -> f64 {
        let (wanted, slope) = self.at(time);
        (slope + GAIN * (wanted - speed)).clamp(LIMITS.0, LIMITS.1)
    }
}

/// What brings a vehicle with `speed` (m/s) to `wanted` (m/s) within a period (s), m/s².
pub fn toward(wanted: f64, speed: f64, period: f64) -> f64 {
    ((wanted - speed) / period.max(SHORTEST)).clamp(LIMITS.0, LIMITS.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plan_is_followed_along_its_slope() {
        let plan = SpeedPlan::new(vec![(0.5, 10.0), (1.5, 8.0), (2.5, 8.0)]).unwrap();
        assert_eq!(plan.at(0.0), (10.0, 0.0));
        assert_eq!(plan.at(1.0), (9.0, -2.0));
        assert_eq!(plan.at(2.0), (8.0, 0.0));
        assert_eq!(plan.at(9.0), (8.0, 0.0));
        assert_eq!(plan.acceleration(1.0, 9.5), -2.5);
        assert_eq!(plan.acceleration(9.0, 0.0), 3.0);
        assert_eq!(plan.acceleration(9.0, 50.0), -8.0);
    }

    #[test]
    fn what_is_no_plan_is_refused() {
        let plan = |points: &[(f64, f64)]| SpeedPlan::new(points.to_vec()).unwrap_err();
        assert_eq!(plan(&[]), SpeedPlanError::Empty);
        assert_eq!(plan(&[(0.0, 1.0), (0.0, 2.0)]), SpeedPlanError::NotAscending(0.0, 0.0));
        assert_eq!(plan(&[(0.0, -1.0)]), SpeedPlanError::Speed(-1.0));
        assert!(matches!(plan(&[(0.0, f64::NAN)]), SpeedPlanError::Speed(_)));
        assert!(matches!(plan(&[(f64::NAN, 1.0)]), SpeedPlanError::Time(_)));
        let long: Vec<_> = (0..17).map(|k| (f64::from(k), 1.0)).collect();
        assert_eq!(plan(&long), SpeedPlanError::TooLong(17));
    }

    #[test]
    fn a_speed_is_reached_within_the_period() {
        assert_eq!(toward(9.0, 10.0, 0.5), -2.0);
        assert_eq!(toward(9.5, 10.0, 0.1), -2.5);
        assert_eq!(toward(0.0, 10.0, 0.1), -8.0);
    }
}
