//! Motion at a constant acceleration that never rolls backwards.

use sim::Longitudinal;

/// Moves on by `step` s at a constant acceleration (m/s²); stops at zero speed and reports the mean acceleration
/// that was realised.
pub(super) fn accelerate(motion: &mut Longitudinal, acceleration: f64, step: f64) {
    let before = motion.speed;
    let after = before + acceleration * step;
    if after >= 0.0 {
        motion.travelled += (before + after) / 2.0 * step;
        motion.speed = after;
    } else {
        // Stands after v/|a|, so it covers v²/(2|a|).
        motion.travelled -= before * before / (2.0 * acceleration);
        motion.speed = 0.0;
    }
    motion.acceleration = (motion.speed - before) / step;
}
