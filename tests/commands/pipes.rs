//! Standard output and standard error that nobody reads any more, or that are full: what every command makes of them.

use std::fs::{self, File};
use std::io;
use std::path::Path;
use std::process::{Command, Output, Stdio};

/// Fast, and something of everything: a trial that passes, one that fails, blocks, a gate.
const SUITE: &str = "suite small {
  seed 7
  scenario calm {
    \"Somebody comes late.\"
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; speed 30 km/h }
    pedestrian walker { model carla_walker; start 4 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [1 s, 1.5 s]
    expect { max_deceleration <= 100 m/s^2 }
  }
  scenario rough {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller constant_speed; speed 30 km/h }
    pedestrian walker { model carla_walker; start 1 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [2 s, 3 s, 4 s]
    expect { max_deceleration >= 1 m/s^2 }
  }
}
search low_pet {
  in calm
  minimise pet
  over tta in 1 s .. 4 s
  budget 2 evaluations, by random
}
";

const TUNED: &str = "suite tuned {
  seed 7
  scenario brakes {
    road { lane_width 3.5 m; speed_limit 50 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker { model carla_walker; start 1 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [3 s, 4 s]
    expect { max_deceleration <= 100 m/s^2 }
  }
  gate hard { baseline \"b.json\"; max_deceleration not worse }
}
tune braking {
  on brakes
  over av.controller.braking_distance in 4 m .. 10 m
  minimise mean(time_lost)
  budget 2 evaluations, by random
}
";

/// Every command that there is, in most of the ways in which it can end.
const COMMANDS: [&[&str]; 71] = [
    &["small.suite"],
    &["run", "small.suite", "calm"],
    &["small.suite", "calm", "--color", "always", "--status-level", "all"],
    &["small.suite", "rough", "--github"],
    &["small.suite", "--status-level", "none", "--no-progress"],
    &["small.suite", "--status-level", "dot"],
    &["diff", "small/calm/tta=1s/rep=1", "small.suite", "--set", "tta=1s,2s"],
    &["diff", "small/calm/tta=1s/rep=1", "small.suite", "--set", "tta=3s"],
    &["small.suite", "rough", "--fail-fast", "--test-threads", "1"],
    &["small.suite", "rough", "--record-failures"],
    &[
        "small.suite",
        "calm",
        "--junit",
        "out/a.xml",
        "--json",
        "out/a.json",
        "--tap",
        "out/a.tap",
        "--html",
        "out/a.html",
    ],
    &["small.suite", "calm", "--trace", "out/traces"],
    &["small.suite", "--list"],
    &["small.suite", "--last-failed"],
    &["small.suite", "nobody"],
    &["small.suite", "nobody", "--no-tests", "warn"],
    &["small.suite", "-E", "tag(nothing)"],
    &["small.suite", "-E", "tag("],
    &["bad.scn"],
    &["missing.suite"],
    &["calm"],
    &["small.suite", "two", "filters"],
    &["small.suite", "--unknown"],
    &[],
    &["--help"],
    &["-h"],
    &["--version"],
    &["help"],
    &["help", "run"],
    &["help", "filter"],
    &["help", "nothing"],
    &["init", "new"],
    &["init", "--list", "new"],
    &["init", "."],
    &["check", "small.suite"],
    &["check", "bad.scn"],
    &["check", "bad.scn", "--format", "json"],
    &["check", "bad.scn", "--format", "github"],
    &["check", "bad.scn", "--format", "sarif"],
    &["fmt", "small.suite"],
    &["fmt", "--check", "bad.scn"],
    &["fmt", "--check", "crooked.scn"],
    &["fmt", "-"],
    &["fmt", "missing.scn"],
    &["fmt", "a.yaml"],
    &["convert", "crooked.scn", "--to", "yaml"],
    &["convert", "bad.scn", "--to", "yaml"],
    &["convert", "missing.scn", "--to", "yaml"],
    &["lsp"],
    &["explain"],
    &["explain", "E0401"],
    &["explain", "filter"],
    &["explain", "E9999"],
    &["list", "small.suite"],
    &["list", "small.suite", "--format", "json"],
    &["list", "small.suite", "--tags"],
    &["models"],
    &["models", "carla_walker"],
    &["models", "nothing"],
    &["search", "low_pet", "small.suite", "--journal", "out"],
    &["tune", "braking", "tuned.suite", "--journal", "out", "--save", "out/tuned.scn"],
    &["baseline", "save", "tuned.suite", "--out", "out/b.json"],
    &["baseline", "show", "b.json"],
    &["baseline", "diff", "b.json", "b.json", "--format", "markdown"],
    &["baseline", "show", "missing.json"],
    &["compare", "b.json", "tuned.suite"],
    &["compare", "b.json", "tuned.suite", "--format", "json"],
    &["calibrate", "--print-criteria"],
    &["validate", "hiker", "missing.json"],
    &["replay", "small/rough/tta=2s/rep=1", "small.suite"],
    &["shrink", "small/rough/tta=2s/rep=1", "small.suite", "-o", "out/shrunk.scn"],
];

/// A stream that is not as it should be.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Stream {
    /// Its reader has gone.
    Closed,
    /// It takes not a byte.
    Full,
}

impl Stream {
    fn open(self) -> Stdio {
        match self {
            Self::Closed => {
                let (reader, writer) = io::pipe().unwrap();
                drop(reader);
                writer.into()
            }
            Self::Full => File::options().write(true).open("/dev/full").unwrap().into(),
        }
    }
}

/// A folder as every command finds it; `b.json` is what `tuned.suite` came to.
struct Place {
    folder: tempfile::TempDir,
}

impl Place {
    fn new(baseline: &[u8]) -> Self {
        let place = Self { folder: tempfile::tempdir().unwrap() };
        let crooked = "scenario   a {\n road {lane_width 3.5 m;speed_limit 50 km/h}\nvehicle av { controller constant_speed; speed 30 km/h } }\n";
        let files = [
            ("small.suite", SUITE),
            ("tuned.suite", TUNED),
            ("bad.scn", "scenario bad {\n  vehicle av { sped 3 km/h }\n}\n"),
            ("crooked.scn", crooked),
            ("a.yaml", "scenario: {}\n"),
            ("README.md", "is in the way of `init`\n"),
        ];
        files.iter().for_each(|(name, text)| fs::write(place.path(name), text).unwrap());
        fs::write(place.path("b.json"), baseline).unwrap();
        fs::create_dir(place.path("out")).unwrap();
        place
    }

    fn path(&self, name: &str) -> std::path::PathBuf {
        self.folder.path().join(name)
    }

    fn run(&self, arguments: &[&str], streams: [Option<Stream>; 2]) -> Output {
        let [out, err] = streams.map(|stream| stream.map_or_else(Stdio::piped, Stream::open));
        let mut command = Command::new(env!("CARGO_BIN_EXE_scenario-runner"));
        command.args(arguments).current_dir(self.folder.path()).env_remove("GITHUB_STEP_SUMMARY");
        command.stdin(File::open(self.path("crooked.scn")).unwrap()).stdout(out).stderr(err);
        command.output().expect("the binary runs")
    }

    /// Every file with its length, but for what differs from run to run.
    fn files(&self) -> Vec<(String, u64)> {
        let mut files = Vec::new();
        let mut folders = vec![self.folder.path().to_path_buf()];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
                if entry.file_type().unwrap().is_dir() {
                    folders.push(entry.path());
                } else {
                    let name = entry.path().strip_prefix(self.folder.path()).unwrap().display().to_string();
                    let timed = Path::new(&name).starts_with("out") && name.contains("a.");
                    files.push((name, if timed { 0 } else { entry.metadata().unwrap().len() }));
                }
            }
        }
        files.sort();
        files
    }
}

fn baseline() -> Vec<u8> {
    let place = Place::new(b"");
    place.run(&["baseline", "save", "tuned.suite", "--out", "b.json", "--force"], [None, None]);
    fs::read(place.path("b.json")).unwrap()
}

/// What is wrong with how a command ends, whose streams are as given.
fn complaints(arguments: &[&str], baseline: &[u8]) -> Vec<String> {
    let reference = Place::new(baseline);
    let usual = reference.run(arguments, [None, None]);
    let (earned, written) = (usual.status.code(), reference.files());
    let mut complaints = Vec::new();
    if matches!(earned, Some(101 | 120) | None) {
        complaints
            .push(format!("{arguments:?} ends with {earned:?}: {}", String::from_utf8_lossy(&usual.stderr)));
    }
    for (stream, said) in [(0, &usual.stdout), (1, &usual.stderr)] {
        for how in [Stream::Closed, Stream::Full] {
            let place = Place::new(baseline);
            let mut streams = [None, None];
            streams[stream] = Some(how);
            let output = place.run(arguments, streams);
            let is_lost = how == Stream::Full && !said.is_empty();
            let expected = if is_lost { Some(110) } else { earned };
            let text = String::from_utf8_lossy(&output.stderr);
            let mut complain = |what: String| {
                complaints.push(format!(
                    "{arguments:?} with {} {how:?}: {what}\n{text}",
                    ["stdout", "stderr"][stream]
                ));
            };
            if output.status.code() != expected {
                complain(format!("{:?} instead of {expected:?}", output.status));
            }
            if text.contains("panicked") {
                complain("a panic".to_string());
            }
            if place.files() != written {
                complain(format!("{:?} instead of {written:?}", place.files()));
            }
            let message = "error: cannot write to standard output: ";
            if stream == 0 && text.contains(message) != is_lost {
                complain("what is lost is said, and nothing else is".to_string());
            }
        }
    }
    complaints
}

#[test]
fn nobody_panics_at_a_closed_pipe_and_what_is_lost_is_said() {
    let baseline = baseline();
    let (left, right) = COMMANDS.split_at(COMMANDS.len() / 2);
    let all = |commands: &[&[&str]]| -> Vec<String> {
        commands.iter().flat_map(|arguments| complaints(arguments, &baseline)).collect()
    };
    let complaints = std::thread::scope(|scope| {
        let left = scope.spawn(|| all(left));
        let right = all(right);
        [left.join().unwrap(), right].concat()
    });
    assert!(
        complaints.is_empty(),
        "{} of {}:\n{}",
        complaints.len(),
        COMMANDS.len() * 4,
        complaints.join("\n")
    );
}

#[test]
fn commands_end_as_they_are_meant_to() {
    // What the test above compares with has to be more than errors of usage.
    let baseline = baseline();
    let code = |arguments: &[&str]| Place::new(&baseline).run(arguments, [None, None]).status.code().unwrap();
    for (arguments, expected) in [
        (&["small.suite"][..], 100),
        (&["small.suite", "calm"], 0),
        (&["check", "bad.scn"], 3),
        (&["search", "low_pet", "small.suite", "--journal", "out"], 0),
        (&["tune", "braking", "tuned.suite", "--journal", "out"], 0),
        (&["compare", "b.json", "tuned.suite"], 0),
        (&["replay", "small/rough/tta=2s/rep=1", "small.suite"], 0),
        (&["shrink", "small/rough/tta=2s/rep=1", "small.suite", "-o", "out/shrunk.scn"], 0),
    ] {
        assert_eq!(code(arguments), expected, "{arguments:?}");
    }
}
