//! A pedestrian that walks by a fixed script: wait, walk, perhaps stop for a while, go on.

use super::{PedestrianContext, PedestrianModel};
use scenario::{Chance, Declaration, Dimension, Parameter};
use sim::{Mode, ModelError, Motion, Pedestrian, Scene};

const FREE: &str = "free choice";

pub fn scripted() -> PedestrianModel {
    let declaration = Declaration::new(
        "scripted",
        "Walks to its goal at a constant speed after a delay, blind to traffic; may \
         stop on the way and go on.",
    )
    .source("fixed script")
    .parameters([
        Parameter::number("speed", Dimension::SPEED, 1.4, (0.0, 12.0), "Walking speed.", FREE),
        Parameter::number(
            "delay",
            Dimension::TIME,
            0.0,
            (0.0, 600.0),
            "Time that it stands after it appeared.",
            FREE,
        ),
        Parameter::optional(
            "acceleration_way",
            Dimension::LENGTH,
            (0.01, 100.0),
            "Way on which it gets from standing to its speed, evenly, whenever it sets off; without it, at once.",
            FREE,
        ),
        Parameter::optional(
            "stop_after",
            Dimension::LENGTH,
            (0.0, 1000.0),
            "Stops after walking this far; without it, it never stops.",
            FREE,
        ),
        Parameter::optional(
            "stop_for",
            Dimension::TIME,
            (0.0, 600.0),
            "Time that it stands there before it walks on; without it, it stays.",
            FREE,
        ),
        Parameter::optional(
            "wait_on_refuge",
            Dimension::TIME,
            (0.0, 600.0),
            "Time that it stands on every refuge of its way, if it waits on refuges.",
            FREE,
        ),
    ]);
    PedestrianModel::new(declaration, build)
        .in_legs()
        .chance(Chance::Never)
        .fixed(|settings| settings.optional_number("keeps_clear").is_none())
        .told_where_to_go()
}

struct Scripted {
    speed: f64,
    delay: f64,
    /// m; `None`: at once.
    acceleration_way: Option<f64>,
    /// When it set off, s; `None` while it stands.
    set_off: Option<f64>,
    stop_for: f64,
    wait_on_refuge: f64,
    /// Distance left until it stops, m; infinite when it will not stop (again).
    left: f64,
    /// As it was before the last step.
    left_before: f64,
    /// When it may walk, s; `None` before its first step.
    walks_from: Option<f64>,
    mode: &'static str,
}

fn build(context: &PedestrianContext) -> Result<Box<dyn Pedestrian>, ModelError> {
    let settings = context.settings;
    let stop_after = settings.optional_number("stop_after");
    if stop_after.is_none() && settings.optional_number("stop_for").is_some() {
        return Err(ModelError::with_hint(
            "`stop_for` of `scripted` says how long it stops, but not where",
            "add `stop_after: 2 m`",
        ));
    }
    let wait_on_refuge = settings.optional_number("wait_on_refuge");
    if wait_on_refuge.is_none() && !context.setup.stops.is_empty() {
        return Err(ModelError::with_hint(
            "`scripted` waits on a refuge, but nothing says how long",
            "add `wait_on_refuge: 2 s`",
        ));
    }
    if wait_on_refuge.is_some() && context.setup.stops.is_empty() {
        return Err(ModelError::with_hint(
            "`wait_on_refuge` of `scripted` says how long it waits on a refuge, but it waits on none",
            "let the pedestrian say `waits on refuge`",
        ));
    }
    Ok(Box::new(Scripted {
        speed: settings.number("speed"),
        delay: settings.number("delay"),
        acceleration_way: settings.optional_number("acceleration_way"),
        set_off: None,
        stop_for: settings.optional_number("stop_for").unwrap_or(f64::INFINITY),
        wait_on_refuge: wait_on_refuge.unwrap_or(0.0),
        left: stop_after.unwrap_or(f64::INFINITY),
        left_before: stop_after.unwrap_or(f64::INFINITY),
        walks_from: None,
        mode: "waiting",
    }))
}

/// Speeds in a step, m/s.
struct Pace {
    mean: f64,
    at_the_end: f64,
}

impl Scripted {
    /// What it walks in the step that begins, where nothing ends its way: uniformly accelerated from standing to its speed, then at that.
    fn wanted(&mut self, scene: &Scene) -> Pace {
        let Some(way) = self.acceleration_way.filter(|_| self.speed > 0.0) else {
            return Pace { mean: self.speed, at_the_end: self.speed };
        };
        let began = scene.time - *self.set_off.get_or_insert(scene.time);
        let duration = 2.0 * way / self.speed;
        if began >= duration {
            return Pace { mean: self.speed, at_the_end: self.speed };
        }
        let gone = |time: f64| match time < duration {
            true => way * (time / duration) * (time / duration),
            false => self.speed * time - way,
        };
        let ends = began + scene.step;
        Pace {
            mean: (gone(ends) - gone(began)) / scene.step,
            at_the_end: self.speed * (ends / duration).min(1.0),
        }
    }
}

/// Absorbs the rounding of summed times, s.
const TIME_TOLERANCE: f64 = 1e-9;

impl Pedestrian for Scripted {
    fn begin_leg(&mut self, scene: &Scene) {
        self.walks_from = Some(scene.time + self.wait_on_refuge);
        (self.set_off, self.mode) = (None, "on_refuge");
    }

    fn act(&mut self, scene: &Scene) -> Motion {
        let ego = scene.ego();
        if scene.held {
            // It did not walk what it meant to, and sets off anew.
            (self.left, self.set_off) = (self.left_before, None);
        }
        let mut walks_from = *self.walks_from.get_or_insert(scene.time + self.delay);
        if self.left <= 0.0 {
            walks_from = scene.time + self.stop_for;
            self.walks_from = Some(walks_from);
            self.left = f64::INFINITY;
            self.mode = "stopped";
        }
        if scene.time < walks_from - TIME_TOLERANCE {
            self.set_off = None;
            return Motion::Walk(nalgebra::Vector2::zeros());
        }
        self.mode = "walking";
        let to_goal = nalgebra::Vector2::new(scene.goal.x, scene.goal.y) - ego.position;
        let distance = to_goal.norm().min(self.left);
        let Some(way) = to_goal.try_normalize(1e-9) else {
            self.mode = "arrived";
            return Motion::Walk(nalgebra::Vector2::zeros());
        };
        let wanted = self.wanted(scene);
        let (speed, displacement) = match distance / scene.step {
            arriving if arriving <= wanted.mean => (arriving, None),
            _ if wanted.mean == wanted.at_the_end => (wanted.mean, None),
            _ => (wanted.mean, Some((wanted.mean - wanted.at_the_end) * scene.step)),
        };
        self.left_before = self.left;
        self.left -= speed * scene.step;
        if self.left < 1e-9 {
            self.left = 0.0;
        }
        match displacement {
            None => Motion::Walk(way * speed),
            Some(displacement) => {
                Motion::Pushed { velocity: way * wanted.at_the_end, displacement: way * displacement }
            }
        }
    }

    fn mode(&self) -> Mode {
        Mode::new(self.mode)
    }

    fn free_speed(&self) -> f64 {
        self.speed
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pedestrian::test_walk::Walk;
    use scenario::{Settings, Value};

    fn number(value: f64) -> Value {
        Value::Number(value)
    }

    #[test]
    fn walks_after_the_delay_and_stops_at_the_goal() {
        let mut walk = Walk::new(&scripted(), Settings::from([("delay", number(1.0))]));
        walk.go(1.0);
        assert_eq!(walk.position().y, -4.0);
        walk.go(1.0);
        assert!((walk.position().y + 4.0 - 1.4).abs() < 1e-9);
        walk.go(10.0);
        assert!((walk.position().y - 6.0).abs() < 1e-9);
    }

    #[test]
    fn gets_to_its_speed_on_its_acceleration_way_whenever_it_sets_off() {
        let settings = [
            ("speed", number(2.0)),
            ("acceleration_way", number(1.5)),
            ("stop_after", number(3.0)),
            ("delay", number(0.5)),
            ("stop_for", number(1.0)),
        ];
        let mut walk = Walk::new(&scripted(), Settings::from(settings));
        walk.go(0.5);
        assert_eq!(walk.position().y, -4.0);
        // 2 * 1.5 m / 2 m/s = 1.5 s; half of that time is a quarter of the way.
        walk.go(0.75);
        assert!((walk.position().y + 4.0 - 1.5 / 4.0).abs() < 1e-9, "{}", walk.position().y);
        walk.go(1.0);
        assert!((walk.position().y + 4.0 - 2.0).abs() < 1e-9, "{}", walk.position().y);
        // It arrives at 3 m, stands for a second, and sets off as slowly as at first.
        walk.go(0.5);
        assert!((walk.position().y + 4.0 - 3.0).abs() < 1e-9, "{}", walk.position().y);
        walk.go(1.75);
        assert!((walk.position().y + 4.0 - 3.0 - 1.5 / 4.0).abs() < 1e-9, "{}", walk.position().y);
    }

    #[test]
    fn stops_where_told_and_goes_on() {
        let settings = [("stop_after", number(3.0)), ("stop_for", number(2.0)), ("speed", number(1.0))];
        let mut walk = Walk::new(&scripted(), Settings::from(settings));
        walk.go(4.5);
        assert!((walk.position().y + 1.0).abs() < 1e-9);
        walk.go(1.5);
        assert!((walk.position().y - 0.0).abs() < 1e-9, "{}", walk.position().y);
        let mut stays = Walk::new(&scripted(), Settings::from([("stop_after", number(3.0))]));
        stays.go(100.0);
        assert!((stays.position().y + 1.0).abs() < 1e-9);
    }

    #[test]
    fn a_stop_without_a_place_is_an_error() {
        let error = Walk::try_new(&scripted(), Settings::from([("stop_for", number(2.0))])).err().unwrap();
        assert!(error.hint.is_some());
    }
}
