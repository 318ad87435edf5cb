//! Result of one run: the gap of the near stream in which the person went, and how.

use std::sync::Arc;

use crate::run::MeasuredMetrics;
use results::{Outcome, Requests};
use scenario::registry::Registry;
use scenario::{Case, MetricReference, TrafficStream, Value};

/// As the scenario calls the stream of the near lane.
pub const NEAR: &str = "near";
/// As it calls the person.
const WALKER: &str = "walker";

/// The gap that is looked at, counted from 1.
pub const LOOKED_AT: usize = 4;

/// Gaps are told apart to this, s.
const SAME: f64 = 1e-6;

/// When a person went.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Went {
    /// Before the front of the first car had passed.
    BeforeFirst,
    /// In the gap of this number, counted from 1; with the last after the last car, which is none of those that are looked at.
    InGap(usize),
    /// Not at all: neither across nor hit when the run was over.
    Never,
}

/// Result of one run.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walk {
    /// A person that is hit on the near lane went in the gap in which it entered the lane, or, where that is not known, in which it was hit.
    pub went: Went,
    /// From the front of the previous car to entering the near lane, s; `None` of a person that does not get across it.
    pub after_previous: Option<f64>,
    /// On leaving the near lane until the next car is there, s; 0 of a person that is hit on it.
    pub left: Option<f64>,
    /// Mean on the near lane, m/s.
    pub speed: Option<f64>,
    /// Whether a car hit the person.
    pub was_hit: bool,
    /// Whether it left a lane by the side that it came from.
    pub stepped_back: Option<bool>,
}

/// What is read off every run.
pub struct GapMetrics {
    gap_taken: MetricReference,
    gaps_missed: MetricReference,
    after_previous: MetricReference,
    left: MetricReference,
    duration: MetricReference,
    first_entry: MetricReference,
    collision: MetricReference,
    step_back: MetricReference,
    pub measured: Arc<MeasuredMetrics>,
}

impl GapMetrics {
    /// Those of a registry.
    ///
    /// # Errors
    /// The first that it does not have, in words.
    pub fn of(registry: &Registry) -> Result<Self, String> {
        let metric = |name: &str| {
            let known = registry.metrics().get(name).map(MetricReference::plain);
            known.ok_or_else(|| format!("there is no metric called `{name}`"))
        };
        let of_pair = |name: &str, first: String, of_stream: bool| {
            metric(name).map(|plain| MetricReference {
                pair: Some((first, WALKER.into())),
                of_stream,
                ..plain
            })
        };
        let of_stream = |name: &str| of_pair(name, NEAR.into(), true);
        let with = |mut metric: MetricReference, name: &str, value: Value| {
            metric.settings.set(name, value);
            metric
        };
        let closes = TrafficStream::member_name(NEAR, LOOKED_AT);
        let all = Self {
            gap_taken: of_stream("gap_taken")?,
            gaps_missed: of_stream("gaps_missed")?,
            after_previous: of_stream("entry_after_previous")?,
            left: with(metric("time_left_on_leaving")?, "lane", Value::Number(0.0)),
            duration: of_pair("crossing_duration", TrafficStream::member_name(NEAR, 0), false)?,
            first_entry: with(
                of_pair("tta_at_entry", closes, false)?,
                "reference",
                Value::Word("front".into()),
            ),
            collision: metric("collision")?,
            step_back: metric("step_back")?,
            measured: Arc::default(),
        };
        let mut requests = Requests::default();
        let Self { gap_taken, gaps_missed, after_previous, left, .. } = &all;
        [gap_taken, gaps_missed, after_previous, left].into_iter().for_each(|one| requests.add(one));
        let Self { duration, first_entry, collision, step_back, .. } = &all;
        [duration, first_entry, collision, step_back].into_iter().for_each(|one| requests.add(one));
        Ok(Self { measured: MeasuredMetrics::new(requests), ..all })
    }

    /// Result of a run.
    ///
    /// # Errors
    /// What does not fit together, in words.
    pub fn walk(&self, case: &Case, outcome: &Outcome) -> Result<Walk, String> {
        let index = |metric: &MetricReference| self.measured.requests.index(metric);
        let value = |metric: &MetricReference| *outcome.metrics.get(index(metric)?)?;
        let moment = |metric: &MetricReference| {
            outcome.critical.get(index(metric)?).filter(|_| value(metric).is_some())?.time
        };
        let near = case.world.streams.iter().find(|stream| stream.name == NEAR);
        let near = near.ok_or_else(|| format!("{}: there is no stream `{NEAR}`", outcome.key))?;
        let was_hit = value(&self.collision) == Some(1.0);
        // A car may push a person along the lane into places where it is not known when a front passes.
        let stepped_back = value(&self.step_back).map(|back| back == 1.0);
        let only_entry = || moment(&self.first_entry).filter(|_| stepped_back != Some(true));
        let hit = || only_entry().or_else(|| moment(&self.collision)).filter(|_| was_hit);
        let entered = moment(&self.gap_taken).or_else(|| moment(&self.gaps_missed)).or_else(hit);
        let went = match entered {
            None if was_hit => {
                return Err(format!("{}: it is not known when the person was hit", outcome.key));
            }
            None => Went::Never,
            Some(entered) => match fronts(case, near).filter(|front| *front <= entered).count() {
                0 => Went::BeforeFirst,
                gap => Went::InGap(gap),
            },
        };
        if let (Some(size), Went::InGap(gap)) = (value(&self.gap_taken), went) {
            let own = near.arrivals.get(gap).map(|next| next - near.arrivals[gap - 1]);
            if own.is_none_or(|own| (own - size).abs() > SAME) {
                return Err(format!(
                    "{}: the person took a gap of {size} s, and not number {gap}",
                    outcome.key
                ));
            }
        }
        let speed = |duration: f64| case.world.road.lane_width / duration;
        Ok(Walk {
            went,
            after_previous: value(&self.after_previous),
            left: value(&self.left),
            speed: value(&self.duration).filter(|duration| *duration > 0.0).map(speed),
            was_hit,
            stepped_back,
        })
    }
}

/// When the front of each car of a stream passes the person's way, s. None of them slows down.
fn fronts<'a>(case: &'a Case, stream: &'a TrafficStream) -> impl Iterator<Item = f64> + 'a {
    stream.vehicles.iter().zip(&stream.arrivals).map(|(vehicle, arrival)| {
        let car = &case.world.vehicles[*vehicle];
        arrival - car.length / 2.0 / car.speed
    })
}
