//! What goes otherwise in a run than its world has it: a vehicle that brakes earlier or harder, people who come later or never.

use serde::{Deserialize, Serialize};

use scenario::agent::{Command, Longitudinal};

/// Absorbs the rounding of sums and products when times are compared, s: that of whoever asks controllers.
pub(super) const TIME_TOLERANCE: f64 = 1e-9;

/// What goes otherwise in a run than its world has it. Everybody reacts to it as they do, on the same noise.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum RunChange {
    /// From `from` (s) on a vehicle is told whichever brakes harder: what is decided for it, or what it was told `by` s later in
    /// another run.
    BrakesEarlier {
        /// Its index.
        vehicle: usize,
        /// s
        from: f64,
        /// s
        by: f64,
        /// What it was told in that run, in the order of time.
        commands: Vec<GivenCommand>,
        /// When that run ended, s: from then on there is only what is decided.
        until: f64,
    },
    /// From `from` (s) until a pedestrian has left its lane a vehicle loses just that much speed until it stands, whatever is decided and
    /// its dynamics make of it.
    Decelerates {
        /// Its index.
        vehicle: usize,
        /// s
        from: f64,
        /// m/s², not negative.
        deceleration: f64,
        /// The pedestrian's index; `None`: to the end of the run.
        until_gone: Option<usize>,
    },
    /// A pedestrian appears so much (s) later than they would.
    AppearsLater {
        /// Its index.
        pedestrian: usize,
        /// s
        by: f64,
    },
    /// No pedestrian appears.
    NobodyAppears,
}

/// What a vehicle was told from a moment on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct GivenCommand {
    /// s
    pub time: f64,
    /// What it was told.
    pub command: Command,
}

/// What is told to one vehicle, and what it does, otherwise than decided; or only noted.
#[derive(Debug, Default)]
pub(super) struct Otherwise {
    /// What it was told, where that is wanted.
    pub given: Option<Vec<GivenCommand>>,
    /// What is otherwise, if anything is.
    pub change: Option<RunChange>,
}

impl Otherwise {
    /// What the vehicle is told at `time` (s), where `decided` was decided.
    pub fn command(&mut self, time: f64, decided: Command) -> Command {
        let command = match &self.change {
            Some(RunChange::BrakesEarlier { from, by, commands, until, .. })
                if time >= from - TIME_TOLERANCE && time + by < until - TIME_TOLERANCE =>
            {
                let after = commands.partition_point(|one| one.time <= time + by + TIME_TOLERANCE);
                after.checked_sub(1).map_or(decided, |last| harder(decided, commands[last].command))
            }
            _ => decided,
        };
        if let Some(given) = &mut self.given {
            given.push(GivenCommand { time, command });
        }
        command
    }

    /// Decelerates a vehicle that `before` moved as said at `time` (s), and `duration` (s) later would as `after` says.
    pub fn decelerate(&self, time: f64, duration: f64, before: &Longitudinal, after: &mut Longitudinal) {
        let Some(RunChange::Decelerates { from, deceleration, .. }) = self.change else { return };
        if time < from - TIME_TOLERANCE || duration <= 0.0 {
            return;
        }
        let lost = deceleration * duration;
        let (speed, driven) = if lost > 0.0 && before.speed < lost {
            (0.0, before.speed * before.speed / (2.0 * deceleration))
        } else {
            (before.speed - lost, (before.speed - lost / 2.0) * duration)
        };
        *after = Longitudinal {
            travelled: before.travelled + driven,
            speed,
            acceleration: (speed - before.speed) / duration,
        };
    }
}

/// Whichever of two commands of one kind brakes harder; the first if neither does.
fn harder(one: Command, other: Command) -> Command {
    let is_harder = match (one, other) {
        (Command::Acceleration(one), Command::Acceleration(other)) => other < one,
        (Command::Pedals { throttle, brake }, Command::Pedals { throttle: less, brake: more }) => {
            more > brake || more == brake && less < throttle
        }
        _ => false,
    };
    if is_harder { other } else { one }
}

/// Whether a command brakes: by more than 0.1 m/s², or with the brake.
pub fn brakes(command: Command) -> bool {
    match command {
        Command::Acceleration(acceleration) => acceleration < -0.1,
        Command::Pedals { brake, .. } => brake > 0.0,
    }
}

/// By how much people come later than they would.
#[derive(Debug)]
pub(super) struct Postponed {
    /// Of each pedestrian, s; infinite of who never comes.
    by: Vec<f64>,
    /// When each would have come, s, and how far within a step.
    due: Vec<Option<(f64, f64)>>,
}

impl Postponed {
    /// Of so many people; `None` where nobody comes later.
    pub fn new(change: &RunChange, people: usize) -> Option<Self> {
        let mut by = vec![0.0; people];
        match change {
            RunChange::AppearsLater { pedestrian, by: later } => by[*pedestrian] = *later,
            RunChange::NobodyAppears => by.fill(f64::INFINITY),
            RunChange::BrakesEarlier { .. } | RunChange::Decelerates { .. } => return None,
        }
        Some(Self { by, due: vec![None; people] })
    }

    /// Whether somebody appears at `time` (s), who without this `would` (or has before), `late` s within the step.
    pub fn appears(&mut self, pedestrian: usize, time: f64, would: bool, late: &mut f64) -> bool {
        let due = &mut self.due[pedestrian];
        if due.is_none() && would {
            *due = Some((time, *late));
        }
        let Some((since, was_late)) = *due else { return false };
        *late = was_late;
        time >= since + self.by[pedestrian] - TIME_TOLERANCE
    }

    /// Whether somebody never comes.
    pub fn never(&self, pedestrian: usize) -> bool {
        self.by[pedestrian].is_infinite()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decelerates(deceleration: f64) -> Otherwise {
        Otherwise {
            given: None,
            change: Some(RunChange::Decelerates { vehicle: 0, from: 1.0, deceleration, until_gone: None }),
        }
    }

    #[test]
    fn who_decelerates_loses_just_that_speed_and_stops_where_it_must() {
        let before = Longitudinal { travelled: 10.0, speed: 5.0, acceleration: 0.0 };
        let after_at = |deceleration: f64, time: f64, duration: f64| {
            let mut after = Longitudinal { travelled: 10.0 + 5.0 * duration, ..before };
            decelerates(deceleration).decelerate(time, duration, &before, &mut after);
            after
        };
        let after = |time: f64, duration: f64| after_at(4.0, time, duration);
        assert_eq!(after(0.5, 0.5).speed, 5.0, "before its moment nothing is otherwise");
        assert_eq!(after(1.0, 0.5), Longitudinal { travelled: 12.0, speed: 3.0, acceleration: -4.0 });
        // From 5 m/s at 4 m/s² it takes 25/8 m.
        assert_eq!((after(1.0, 2.0).travelled, after(1.0, 2.0).speed), (13.125, 0.0));
        assert_eq!(after_at(0.0, 1.0, 0.5), Longitudinal { travelled: 12.5, speed: 5.0, acceleration: 0.0 });
        let mut harder = Longitudinal { travelled: 11.0, speed: 1.0, acceleration: -8.0 };
        decelerates(4.0).decelerate(1.0, 0.5, &before, &mut harder);
        assert_eq!(harder.speed, 3.0, "its own brake counts no more");
    }

    #[test]
    fn the_harder_command_is_taken_and_the_decided_one_where_they_are_equal() {
        let pedals = |throttle, brake| Command::Pedals { throttle, brake };
        assert_eq!(harder(pedals(0.5, 0.0), pedals(0.0, 0.3)), pedals(0.0, 0.3));
        assert_eq!(harder(pedals(0.2, 0.0), pedals(0.5, 0.0)), pedals(0.2, 0.0));
        assert_eq!(
            harder(Command::Acceleration(-3.0), Command::Acceleration(1.0)),
            Command::Acceleration(-3.0)
        );
        let mut earlier = Otherwise {
            given: Some(Vec::new()),
            change: Some(RunChange::BrakesEarlier {
                vehicle: 0,
                from: 1.0,
                by: 0.5,
                commands: [(0.0, 0.0), (2.0, -4.0), (3.0, 1.0)]
                    .map(|(time, command)| GivenCommand { time, command: Command::Acceleration(command) })
                    .into(),
                until: 4.0,
            }),
        };
        let told = [0.5, 1.4, 1.5, 2.5, 3.5].map(|time| earlier.command(time, Command::Acceleration(-1.0)));
        assert_eq!(told, [-1.0, -1.0, -4.0, -1.0, -1.0].map(Command::Acceleration));
        assert_eq!(earlier.given.unwrap().len(), 5);
    }

    #[test]
    fn who_comes_later_comes_once_and_who_never_comes_does_not() {
        let mut later = Postponed::new(&RunChange::AppearsLater { pedestrian: 1, by: 0.2 }, 2).unwrap();
        assert!(later.appears(0, 1.0, true, &mut 0.0), "the others come when they do");
        let mut late = 0.01;
        assert!(!later.appears(1, 1.0, true, &mut late));
        late = 0.0;
        assert!(!later.appears(1, 1.1, false, &mut late));
        assert!(later.appears(1, 1.2, false, &mut late) && late == 0.01);
        let mut never = Postponed::new(&RunChange::NobodyAppears, 1).unwrap();
        assert!(!never.appears(0, 1e9, true, &mut 0.0) && never.never(0));
    }
}
