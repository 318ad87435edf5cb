//! A conversation in frames, with columns in an order of their own and one that nobody knows.

use scenario_runner_av::{converse, About, Answer, Command, Controller, Gives, Kind, Parameter, Run, Seen};
use serde_json::{json, Value};

struct Counts {
    steps: f64,
    has_failed: bool,
}

impl Controller for Counts {
    fn start(run: &Run) -> Result<Self, String> {
        assert_eq!(
            (run.number("gap"), run.flag("yields"), run.text("profile")),
            (Ok(2.5), Ok(true), Ok("a"))
        );
        assert!(run.number("gab").is_err());
        if run.slot == 3 {
            return Err("no weights".into());
        }
        Ok(Self { steps: 0.0, has_failed: false })
    }

    fn step(&mut self, seen: &Seen) -> Result<Answer, String> {
        assert_eq!(
            (seen.signal, seen.speed, seen.left_kerb.is_nan()),
            (Some(true), 5.0 + seen.slot as f64, true)
        );
        assert_eq!(
            seen.pedestrians.iter().map(|one| (one.id, one.x, one.kind)).collect::<Vec<_>>(),
            if seen.slot == 1 { vec![(7, 3.5, Kind::Cyclist)] } else { vec![] }
        );
        assert_eq!(seen.vehicles.len(), usize::from(seen.slot == 2));
        assert!(seen.vehicles.iter().all(|one| one.kind == Kind::Vehicle));
        let crossings: Vec<_> =
            seen.crossings.iter().map(|one| (one.distance, one.pedestrian_priority)).collect();
        assert_eq!(crossings, if seen.slot == 2 { vec![(12.5, true), (40.0, false)] } else { vec![] });
        assert_eq!((seen.curvature, seen.gradient.is_nan()), (0.25, true));
        let bends = if seen.slot == 2 { vec![(20.0, 0.0), (45.0, 0.02)] } else { vec![] };
        assert_eq!(seen.curvature_ahead, bends);
        self.steps += 1.0;
        if seen.slot == 2 && !self.has_failed {
            self.has_failed = true;
            return Err("no lane".into());
        }
        Ok(Answer { command: Command::Acceleration(self.steps), mode: Some(0), curvature: None })
    }
}

fn text(value: &Value) -> Vec<u8> {
    let text = value.to_string();
    [&(text.len() as u32 + 4).to_le_bytes()[..], &[0; 4], text.as_bytes()].concat()
}

fn scenes(slots: &[f64], time: f64) -> Vec<u8> {
    let mut rows: Vec<f64> =
        slots.iter().flat_map(|slot| [77.0, 1.0, 5.0 + slot, time, 0.0, *slot, 0.25]).collect();
    let of = |slot: f64| slots.iter().position(|one| *one == slot).map(|row| row as f64);
    let (people, cars) = (of(1.0), of(2.0));
    rows.extend(people.iter().flat_map(|row| [*row, 7.0, 3.5, 2.0]));
    rows.extend(cars.iter().flat_map(|row| [30.0, *row]));
    rows.extend(cars.iter().flat_map(|row| [20.0, *row, 0.0, 45.0, *row, 0.02]));
    rows.extend(cars.iter().flat_map(|row| [12.5, 1.0, *row, 40.0, 0.0, *row]));
    let counts = [slots.len() as u32, people.iter().count() as u32, cars.iter().count() as u32];
    let words =
        [28 + 8 * rows.len() as u32, 1, counts[0], counts[1], counts[2], 2 * counts[2], 2 * counts[2], 0];
    let words = words.iter().flat_map(|word| word.to_le_bytes());
    words.chain(rows.iter().flat_map(|value| value.to_le_bytes())).collect()
}

fn rows(values: &[f64]) -> Vec<u8> {
    let words = [12 + 16 * values.len() as u32, 2, values.len() as u32, 2];
    let words = words.iter().flat_map(|word| word.to_le_bytes());
    words.chain(values.iter().flat_map(|value| [*value, 0.0]).flat_map(f64::to_le_bytes)).collect()
}

#[test]
fn runs_begin_are_decided_and_refused() {
    let columns = json!({
        "runs": ["later", "signal", "speed", "time", "new", "slot"], "lanes": ["curvature"], "pedestrians": ["row", "id", "x"],
        "vehicles": ["x", "row"], "curvature_ahead": ["distance", "row", "curvature"],
        "kinds": ["kind"], "crossings": ["distance", "pedestrian_priority", "row"],
    });
    let greeting = json!({"hello": {"protocol": 1, "columns": columns}}).to_string() + "\n";
    let run = |slot: u32| {
        json!({"slot": slot, "seed": 9007199254740991_u64, "step": 0.025, "parameters": {"gap": 2.5, "yields": true, "profile": "a"},
            "cruise_speed": 8.0, "vehicle": {"length": 4.5, "width": 1.8}, "later": [],
            "road": {"lane_width": 4.0, "speed_limit": 8.0, "lanes": [{"y": 0.0, "direction": 1}], "kerbs": {"right": -2.0, "left": 2.0},
                "crossing": {"kind": "zebra", "width": 4.0, "x": 0.0}, "boxes": []}})
    };
    let opened = json!({"open": [run(0), run(1), run(2), run(3)]});
    let said = [
        greeting.into_bytes(),
        text(&opened),
        scenes(&[0.0, 1.0, 2.0], 0.0),
        // What stands beside a run that was refused is asked for again, and not decided twice.
        scenes(&[0.0, 1.0], 0.0),
        scenes(&[1.0, 0.0], 0.1),
        text(&json!({"close": [{"slot": 0, "reason": "completed"}]})),
        text(&json!({"bye": {}})),
        text(&opened),
    ]
    .concat();
    let about = About {
        name: "counts".into(),
        version: "1".into(),
        gives: Gives::Acceleration,
        runs_at_once: 4,
        modes: vec!["cruise".into()],
        parameters: vec![
            Parameter::number("gap", "m", 5.0, (1.0, 30.0)),
            Parameter::whole("horizon", 5, (1, 30)),
        ],
    };
    let mut answers = Vec::new();
    converse::<Counts>(&about, &said[..], &mut answers).unwrap();
    let end = answers.iter().position(|byte| *byte == b'\n').unwrap();
    let hello: Value = serde_json::from_slice(&answers[..end]).unwrap();
    assert!(answers.starts_with(b"{\"hello\""));
    assert_eq!(hello["hello"]["gives"], json!(["acceleration"]));
    assert_eq!(
        hello["hello"]["parameters"][1],
        json!({"name": "horizon", "default": 5, "low": 1, "high": 30})
    );
    let wanted = [
        text(&json!({"ready": [0, 1, 2], "failed": [{"slot": 3, "message": "no weights"}]})),
        text(&json!({"error": [{"slot": 2, "message": "no lane"}]})),
        rows(&[1.0, 1.0]),
        rows(&[2.0, 2.0]),
    ]
    .concat();
    assert_eq!(answers[end + 1..], wanted);
}

struct Gives32;

impl Controller for Gives32 {
    fn start(_: &Run) -> Result<Self, String> {
        Ok(Self)
    }

    fn step(&mut self, _: &Seen) -> Result<Answer, String> {
        Ok(Command::Speed(5.0).into())
    }
}

#[test]
fn what_is_not_of_the_kind_that_was_announced_is_an_error() {
    let columns = json!({"runs": ["time", "slot"], "pedestrians": [], "vehicles": []});
    let run = json!({"slot": 0, "seed": 1, "step": 0.025, "parameters": {}, "cruise_speed": 8.0, "vehicle": {"length": 4.5, "width": 1.8},
        "road": {"lane_width": 4.0, "speed_limit": 8.0, "lanes": [], "kerbs": {"right": -2.0, "left": 2.0},
            "crossing": {"kind": "zebra", "width": 4.0}, "boxes": []}});
    let step = [28 + 16, 1, 1, 0, 0, 0, 0, 0_u32].iter().flat_map(|word| word.to_le_bytes());
    let step: Vec<u8> = step.chain([0.5_f64, 0.0].iter().flat_map(|value| value.to_le_bytes())).collect();
    let greeting = json!({"hello": {"protocol": 1, "columns": columns}}).to_string() + "\n";
    let said = [greeting.into_bytes(), text(&json!({"open": [run]})), step].concat();
    let about = About {
        name: "gives".into(),
        version: "1".into(),
        gives: Gives::Acceleration,
        runs_at_once: 1,
        modes: vec![],
        parameters: vec![],
    };
    let mut answers = Vec::new();
    converse::<Gives32>(&about, &said[..], &mut answers).unwrap();
    let last = String::from_utf8_lossy(&answers).into_owned();
    assert!(last.contains("it answered Speed(5.0), but says that it gives Acceleration"), "{last}");
}

struct Steers;

impl Controller for Steers {
    fn start(_: &Run) -> Result<Self, String> {
        Ok(Self)
    }

    fn step(&mut self, seen: &Seen) -> Result<Answer, String> {
        let curvature = (seen.lateral_offset != 0.0).then_some(-0.1 * seen.lateral_offset);
        Ok(Answer { curvature, ..Command::Acceleration(seen.heading_error).into() })
    }
}

#[test]
fn a_curvature_stands_behind_the_mode_where_the_runner_takes_one() {
    let run = json!({"slot": 0, "seed": 1, "step": 0.025, "parameters": {}, "cruise_speed": 8.0, "vehicle": {"length": 4.5, "width": 1.8},
        "road": {"lane_width": 4.0, "speed_limit": 8.0, "lanes": [], "kerbs": {"right": -2.0, "left": 2.0},
            "crossing": {"kind": "zebra", "width": 4.0}, "boxes": []}});
    let about = About {
        name: "steers".into(),
        version: "1".into(),
        gives: Gives::Acceleration,
        runs_at_once: 1,
        modes: vec![],
        parameters: vec![],
    };
    let answered = |lanes: Value, scenes: &[&[f64]]| {
        let columns = json!({"runs": ["time", "slot"], "lanes": lanes, "pedestrians": [], "vehicles": []});
        let greeting = json!({"hello": {"protocol": 1, "columns": columns}}).to_string() + "\n";
        let mut said = [greeting.into_bytes(), text(&json!({"open": [run]}))].concat();
        for row in scenes {
            let words = [28 + 8 * row.len() as u32, 1, 1, 0, 0, 0, 0, 0];
            said.extend(words.iter().flat_map(|word| word.to_le_bytes()));
            said.extend(row.iter().flat_map(|value| value.to_le_bytes()));
        }
        let mut answers = Vec::new();
        converse::<Steers>(&about, &said[..], &mut answers).unwrap();
        answers
    };
    let row = |values: &[f64]| -> Vec<u8> {
        let words = [12 + 8 * values.len() as u32, 2, 1, values.len() as u32];
        let words = words.iter().flat_map(|word| word.to_le_bytes());
        words.chain(values.iter().flat_map(|value| value.to_le_bytes())).collect()
    };
    let known = answered(
        json!(["heading_error", "lateral_offset"]),
        &[&[0.5, 0.0, 0.02, 2.0], &[0.6, 0.0, 0.0, 0.0]],
    );
    assert!(known.ends_with(&[row(&[0.02, -1.0, -0.2]), row(&[0.0, -1.0])].concat()));
    // An older one says neither, and its rows have one column less.
    let older = answered(json!(["heading_error"]), &[&[0.5, 0.0, 0.02]]);
    assert!(String::from_utf8_lossy(&older).contains("this runner takes none"));
}
