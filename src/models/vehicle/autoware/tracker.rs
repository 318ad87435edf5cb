//! The tracker: delayed detections become targets with smoothed velocities (specification §4, §5.1).

use std::collections::VecDeque;

use nalgebra::Vector2;

use numbers::random::Stream;
use scenario::{Settings, Shape};
use sim::Observation;

/// Absorbs the rounding of differences of times, s.
const TOLERANCE: f64 = 1e-6;

/// A pedestrian as the tracker publishes it. Axes: s along the lane from the middle of the crossing, y to the left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackedTarget {
    /// Centre, m.
    pub position: Vector2<f64>,
    /// m/s
    pub velocity: Vector2<f64>,
    /// Half the side of its box, m.
    pub half_size: f64,
}

#[derive(Debug, Clone, Copy)]
struct Constants {
    sensor_delay: f64,
    /// Share of the innovation that the velocity takes over at each tick.
    velocity_gain: f64,
    confirmation_hits: u32,
    detection_range: f64,
    miss_probability: f64,
    lifetime: f64,
    period: f64,
}

/// Tracks every pedestrian. A track's index is the pedestrian's number.
pub struct Tracker {
    constants: Constants,
    tracks: Vec<Track>,
    misses: Stream,
}

#[derive(Default)]
struct Track {
    /// What the sensor saw at the times of the last calls, oldest first, as far back as the delay needs.
    frames: VecDeque<Frame>,
    estimate: Option<Estimate>,
}

#[derive(Clone, Copy)]
struct Frame {
    time: f64,
    detection: Option<TrackedTarget>,
}

#[derive(Clone, Copy)]
struct Estimate {
    target: TrackedTarget,
    hits: u32,
    last_hit: f64,
}

impl Tracker {
    /// For `pedestrians` numbered from 0; `misses` draws detections that fail.
    pub fn new(settings: &Settings, pedestrians: usize, misses: Stream) -> Self {
        let period = settings.number("planning_period");
        let time_constant = settings.number("velocity_time_constant");
        let kept = if time_constant > 0.0 { libm::exp(-period / time_constant) } else { 0.0 };
        let constants = Constants {
            sensor_delay: settings.number("sensor_delay"),
            velocity_gain: 1.0 - kept,
            confirmation_hits: settings.number("confirmation_hits") as u32,
            detection_range: settings.number("detection_range"),
            miss_probability: settings.number("miss_probability"),
            lifetime: settings.number("track_lifetime"),
            period,
        };
        let tracks = (0..pedestrians).map(|_| Track::default()).collect();
        Self { constants, tracks, misses }
    }

    /// How many pedestrians it knows.
    pub fn len(&self) -> usize {
        self.tracks.len()
    }

    /// Takes what the sensor sees now. To be called at every observation.
    pub fn sense(&mut self, observation: &Observation) {
        let highest = observation.pedestrians.iter().map(|seen| seen.id + 1).max().unwrap_or(0);
        while self.tracks.len() < highest {
            self.tracks.push(Track::default());
        }
        let time = observation.time;
        for track in &mut self.tracks {
            track.frames.push_back(Frame { time, detection: None });
        }
        let ego = observation.ego.travelled;
        for seen in &observation.pedestrians {
            if seen.position.norm() < self.constants.detection_range {
                let half_size = match seen.shape {
                    Shape::Disc { radius } => radius,
                    Shape::Rectangle { length, width } => length.max(width) / 2.0,
                };
                let position = Vector2::new(ego + seen.position.x, seen.position.y);
                let frame = self.tracks[seen.id].frames.back_mut();
                if let Some(frame) = frame {
                    frame.detection = Some(TrackedTarget { position, velocity: seen.velocity, half_size });
                }
            }
        }
    }

    /// One tick of all tracks at `time` (s).
    pub fn update(&mut self, time: f64) {
        for track in &mut self.tracks {
            track.update(time, &self.constants, &mut self.misses);
        }
    }

    /// The confirmed target with number `index`, if there is one.
    pub fn target(&self, index: usize) -> Option<TrackedTarget> {
        let estimate = self.tracks[index].estimate?;
        (estimate.hits >= self.constants.confirmation_hits).then_some(estimate.target)
    }

    /// What is there, confirmed or not: as a point cloud shows it.
    pub fn unconfirmed(&self, index: usize) -> Option<TrackedTarget> {
        self.tracks[index].estimate.map(|estimate| estimate.target)
    }
}

impl Track {
    fn update(&mut self, time: f64, constants: &Constants, misses: &mut Stream) {
        let due = time - constants.sensor_delay + TOLERANCE;
        while self.frames.get(1).is_some_and(|next| next.time <= due) {
            self.frames.pop_front();
        }
        let frame = self.frames.front().filter(|frame| frame.time <= due);
        let missed = |misses: &mut Stream| {
            constants.miss_probability > 0.0 && misses.uniform() < constants.miss_probability
        };
        match frame.and_then(|frame| frame.detection.map(|detection| (frame.time, detection))) {
            Some((measured, detection)) if !missed(misses) => {
                let mut target = detection;
                let mut hits = 1;
                if let Some(known) = self.estimate {
                    let before = known.target.velocity;
                    target.velocity = before + (detection.velocity - before) * constants.velocity_gain;
                    hits = known.hits.saturating_add(1);
                }
                target.position += target.velocity * (time - measured);
                self.estimate = Some(Estimate { target, hits, last_hit: time });
            }
            _ => {
                self.estimate = self.estimate.filter(|known| {
                    known.hits >= constants.confirmation_hits
                        && time - known.last_hit <= constants.lifetime + TOLERANCE
                });
                if let Some(known) = &mut self.estimate {
                    known.target.position += known.target.velocity * constants.period;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vehicle::autoware::autoware;
    use scenario::Value;
    use sim::{EgoState, RoadView, SeenPedestrian};

    fn tracker(settings: Settings) -> Tracker {
        let settings = autoware().declaration.resolve(&settings).unwrap();
        Tracker::new(&settings, 1, Stream::seeded(1))
    }

    fn observation(time: f64, seen: Option<(Vector2<f64>, Vector2<f64>)>) -> Observation {
        Observation {
            time,
            ego: EgoState {
                distance_to_crossing: 50.0,
                speed: 0.0,
                acceleration: 0.0,
                length: 4.89,
                width: 1.896,
                travelled: -50.0,
                curvature: 0.0,
                lateral_offset: 0.0,
                heading_error: 0.0,
            },
            cruise_speed: 8.0,
            road: RoadView {
                lane_width: 4.0,
                speed_limit: 8.0,
                crossing_width: 4.0,
                pedestrian_priority: true,
                signal: None,
                right_kerb: -2.0,
                left_kerb: 2.0,
                gradient: None,
                curvature_ahead: Vec::new(),
                crossings: Vec::new(),
            },
            pedestrians: seen
                .into_iter()
                .map(|(position, velocity)| SeenPedestrian {
                    kind: Default::default(),
                    id: 0,
                    position,
                    velocity,
                    acceleration: Vector2::zeros(),
                    shape: Shape::Disc { radius: 0.25 },
                })
                .collect(),
            vehicles: Vec::new(),
        }
    }

    /// Senses every 25 ms, ticks every 0.1 s; what is published at each tick.
    fn followed(
        tracker: &mut Tracker,
        ticks: usize,
        seen: impl Fn(f64) -> Option<(Vector2<f64>, Vector2<f64>)>,
    ) -> Vec<Option<TrackedTarget>> {
        let mut published = Vec::new();
        for k in 0..=4 * ticks {
            let time = k as f64 * 0.025;
            tracker.sense(&observation(time, seen(time)));
            if k % 4 == 0 {
                tracker.update(time);
                published.push(tracker.target(0));
            }
        }
        published
    }

    #[test]
    fn confirmed_after_the_delay_and_three_hits() {
        let standing = |_| Some((Vector2::new(50.0, -4.0), Vector2::zeros()));
        let published = followed(&mut tracker(Settings::default()), 6, standing);
        // Measured at 0.0, 0.1, 0.2; known at 0.1, 0.2, 0.3.
        let known: Vec<_> = published.iter().map(Option::is_some).collect();
        assert_eq!(known, [false, false, false, true, true, true, true]);
        assert_eq!(published[3].unwrap().position, Vector2::new(0.0, -4.0));
    }

    #[test]
    fn steady_walkers_are_where_they_are_and_new_speeds_come_with_the_time_constant() {
        let velocity = Vector2::new(0.0, 1.4);
        let walking = |time: f64| Some((Vector2::new(50.0, -4.0) + velocity * time, velocity));
        let published = followed(&mut tracker(Settings::default()), 10, walking);
        assert!((published[10].unwrap().position.y - (-4.0 + 1.4)).abs() < 1e-9);

        let starting = |time: f64| {
            let walked = (time - 0.5f64).max(0.0);
            let speed = if time >= 0.5 { 1.4 } else { 0.0 };
            Some((Vector2::new(50.0, -4.0 + 1.4 * walked), Vector2::new(0.0, speed)))
        };
        let published = followed(&mut tracker(Settings::default()), 9, starting);
        // First seen walking at 0.6, four updates up to 0.9: 1 - exp(-0.4/0.4) of it.
        let expected = 1.4 * (1.0 - (-1.0f64).exp());
        assert!((published[9].unwrap().velocity.y - expected).abs() < 1e-12);
    }

    #[test]
    fn out_of_range_or_never_confirmed_is_nobody_and_lost_targets_live_on() {
        let far = |_| Some((Vector2::new(80.0, 0.0), Vector2::zeros()));
        assert!(followed(&mut tracker(Settings::default()), 9, far).iter().all(Option::is_none));
        let flickering =
            |time: f64| ((time * 10.0).round() as i64 % 3 != 2).then_some((Vector2::x(), Vector2::zeros()));
        assert!(followed(&mut tracker(Settings::default()), 20, flickering).iter().all(Option::is_none));
        let leaving = |time: f64| (time < 1.0).then_some((Vector2::new(50.0, 0.0), Vector2::new(0.0, 1.0)));
        let published = followed(&mut tracker(Settings::default()), 25, leaving);
        // Last measured before 1.0, so last hit at 1.0; kept until 2.0.
        assert!(published[20].is_some() && published[21].is_none());
        assert!((published[20].unwrap().position.y - published[10].unwrap().position.y - 1.0).abs() < 1e-9);
        let blind = Settings::from([("miss_probability", Value::Number(1.0))]);
        let near = |_| Some((Vector2::new(50.0, 0.0), Vector2::zeros()));
        assert!(followed(&mut tracker(blind), 9, near).iter().all(Option::is_none));
    }
}
