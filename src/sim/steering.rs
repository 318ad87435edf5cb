//! Where a vehicle goes that its controller steers: the kinematic bicycle model.
//!
//! The rear axle goes where the vehicle points, and the curvature of its way is the tangent of the steering angle over the wheelbase
//! (R. Rajamani, Vehicle Dynamics and Control, 2nd ed. 2012, section 2.2, with the rear axle as reference; P. Polack et al., "The
//! kinematic bicycle model: a consistent model for planning feasible trajectories for autonomous vehicles?", IEEE IV 2017). No tyre slips.
//! Within a step the curvature changes evenly with the way, so that the rear axle takes a piece of a clothoid, exactly.
//!
//! Limits: the front wheels turn no faster than [`FASTEST`] and no farther than [`LARGEST`], and tyres hold so much in all directions
//! together (Kamm's circle): what accelerates or brakes the vehicle is served first, and what is left bounds v² κ. Polack et al. find the
//! model valid up to 0.5 μ g to the side; beyond that real cars understeer more than this one.

use scenario::agent::{Longitudinal, Steered, VehicleState};
use scenario::geometry::Piece;
use scenario::{GRAVITY, Ground, Path, REAR_AXLE, VehicleSetup};

/// The front wheels are turned no faster than this, rad/s: CommonRoad's vehicle models (M. Althoff et al. 2017), as remembered.
const FASTEST: f64 = 0.4;

/// And no farther, rad. The car that German streets are designed for (RASt 06: 4.74 m x 1.76 m) then turns within the 5.85 m about its
/// outer corner that it needs there, as remembered.
const LARGEST: f64 = 0.67;

/// Coefficient of friction of a road that says none: dry asphalt, the upper end of 0.8 to 0.9 in J. Y. Wong, Theory of Ground Vehicles, as
/// remembered.
const DRY: f64 = 0.9;

/// How one vehicle is steered.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steering {
    /// From its centre to either axle, m.
    axle: f64,
    /// How far the point that follows its path is behind its centre, m.
    behind: f64,
    /// What tyres transmit in all directions together, m/s².
    grip: f64,
    /// What gravity takes from its acceleration, m/s².
    slope: f64,
}

impl Steering {
    /// Of a vehicle that drives on `ground`, as it is in its direction.
    pub fn new(setup: &VehicleSetup, ground: &Ground) -> Self {
        Self {
            axle: if setup.behind > 0.0 { setup.behind } else { REAR_AXLE * setup.length },
            behind: setup.behind,
            grip: ground.friction.unwrap_or(DRY) * GRAVITY,
            slope: ground.slope(),
        }
    }

    /// Puts a vehicle, which was moved along its path for `duration` s from the state `before`, where it comes to with the front wheels
    /// turned towards the `wanted` curvature (1/m); without one towards that of its path beside it.
    pub fn follow(&self, car: &mut VehicleState, before: Longitudinal, wanted: Option<f64>, duration: f64) {
        let behind = if car.path.course().is_some() { self.behind } else { 0.0 };
        let mut steered = car.steered.unwrap_or_else(|| self.begin(&car.path, before.travelled));
        let wanted = wanted.unwrap_or_else(|| {
            let bend = car.path.curvature(before.travelled);
            bend / (1.0 - bend * steered.offset).max(0.1)
        });
        let wheelbase = 2.0 * self.axle;
        let asked = libm::atan(wanted * wheelbase).clamp(-LARGEST, LARGEST);
        let turned = FASTEST * duration;
        steered.steering_angle =
            asked.clamp(steered.steering_angle - turned, steered.steering_angle + turned);
        let most = self.most(before, car.motion, duration);
        let curvature = (libm::tan(steered.steering_angle) / wheelbase).clamp(-most, most);
        let way = car.motion.travelled - before.travelled;
        if way > 0.0 {
            let piece = Piece::clothoid(way, steered.curvature.clamp(-most, most), curvature);
            let rear = steered.centre - steered.heading * self.axle;
            let (rear, heading) = piece.followed_from(rear, steered.heading);
            (steered.centre, steered.heading) = (rear + heading * self.axle, heading);
        }
        steered.curvature = curvature;
        let found = car.path.locate(steered.centre - steered.heading * behind);
        steered.offset = found.left();
        let ahead = found.turned(steered.heading);
        steered.heading_error = libm::atan2(ahead.y, ahead.x);
        car.motion.travelled = found.along + behind;
        car.steered = Some(steered);
    }

    /// On its path at a place (m), where it was so far.
    fn begin(&self, path: &Path, place: f64) -> Steered {
        let ((centre, heading), curvature) = (path.pose(place), path.curvature(place));
        Steered {
            centre,
            heading,
            axle: self.axle,
            steering_angle: libm::atan(curvature * 2.0 * self.axle),
            curvature,
            offset: 0.0,
            heading_error: 0.0,
        }
    }

    /// The largest curvature (1/m) that the tyres hold from one state to the next.
    fn most(&self, before: Longitudinal, after: Longitudinal, duration: f64) -> f64 {
        let speed = before.speed.max(after.speed);
        if speed <= 0.0 {
            return f64::INFINITY;
        }
        // What stops within the step brakes harder than it loses speed over all of it.
        let way = after.travelled - before.travelled;
        let along = match after.speed == 0.0 && way > 0.0 {
            true => -before.speed * before.speed / (2.0 * way),
            false => (after.speed - before.speed) / duration,
        };
        let held = along + self.slope;
        libm::sqrt((self.grip * self.grip - held * held).max(0.0)) / (speed * speed)
    }
}

#[cfg(test)]
mod tests;
