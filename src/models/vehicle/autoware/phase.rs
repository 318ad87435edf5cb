//! The state machine that names what the loop is up to (§5.6).

/// What the loop is up to.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Phase {
    #[default]
    Cruise,
    Brake,
    Stopping,
    Wait,
    Go,
    LaneStop,
    MrmStop,
}

/// What its transitions depend on.
#[derive(Debug, Clone, Copy, Default)]
pub struct Signs {
    /// The emergency stop is on.
    pub emergency: bool,
    /// An in-lane stop is the nearest stop.
    pub lane_stop: bool,
    /// There is a stop for the crosswalk and the plan brakes for it.
    pub braking: bool,
    /// There is a stop for the crosswalk.
    pub crosswalk_stop: bool,
    /// The controller is stopping, or holds the ego still.
    pub stopping: bool,
    pub stopped: bool,
    /// The ego is slower than it must be to be under way.
    pub slow: bool,
}

impl Phase {
    pub fn next(self, signs: &Signs) -> Self {
        if signs.emergency {
            return Self::MrmStop;
        }
        if signs.lane_stop {
            return Self::LaneStop;
        }
        if signs.crosswalk_stop {
            return match (signs.stopped, signs.stopping, signs.braking) {
                (true, ..) => Self::Wait,
                (_, true, _) => Self::Stopping,
                (_, _, true) => Self::Brake,
                _ if matches!(self, Self::Brake | Self::Go) => self,
                _ => Self::Cruise,
            };
        }
        if signs.slow && self != Self::Cruise { Self::Go } else { Self::Cruise }
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Cruise => "cruise",
            Self::Brake => "brake",
            Self::Stopping => "stopping",
            Self::Wait => "wait",
            Self::Go => "go",
            Self::LaneStop => "lane_stop",
            Self::MrmStop => "mrm_stop",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_through_a_yield() {
        let stop = Signs { crosswalk_stop: true, ..Signs::default() };
        let signs = [
            Signs::default(),
            stop,
            Signs { braking: true, ..stop },
            stop,
            Signs { stopping: true, slow: true, ..stop },
            Signs { stopped: true, slow: true, ..stop },
            Signs { slow: true, ..Signs::default() },
            Signs::default(),
        ];
        let mut phase = Phase::default();
        let names = signs.map(|signs| {
            phase = phase.next(&signs);
            phase.name()
        });
        assert_eq!(names, ["cruise", "cruise", "brake", "brake", "stopping", "wait", "go", "cruise"]);
    }

    #[test]
    fn lane_and_emergency_stops_come_first() {
        let both = Signs { lane_stop: true, emergency: true, ..Signs::default() };
        assert_eq!(Phase::Wait.next(&both), Phase::MrmStop);
        assert_eq!(Phase::MrmStop.next(&Signs { lane_stop: true, ..Signs::default() }), Phase::LaneStop);
        assert_eq!(Phase::LaneStop.next(&Signs { slow: true, ..Signs::default() }), Phase::Go);
    }
}
