//! Controllers that are functional mock-up units, of FMI 2.0 and 3.0: as their native twin, wired as the file says, and never silently
//! otherwise.

use std::fs;
use std::io::{Cursor, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::{Failed, Outcome, Said, expect, expect_all, gather, many, run, scenario, written_fingerprints};

/// The edition of a unit, and how its description begins and says each variable.
#[derive(Clone, Copy, PartialEq)]
enum Edition {
    Two,
    Three,
}

const EDITIONS: [Edition; 2] = [Edition::Two, Edition::Three];

/// As they are declared: all that the program of these tests sees.
const WIRED: &str = r#"  fmu "own.fmu"
  input ego.speed = "vEgo" in m/s
  input cruise_speed = "vSet"
  input object1.x = "x"
  input object1.y = "y" in m
  input object1.present = "present"
  output acceleration = "axReq" in m/s^2
  parameter gap = 5 m in 1 m .. 30 m as "gap" in m
  parameter kind = "good"
  parameter level = 1 in whole 0 .. 9 as "levels"
"#;

/// What the unit says of itself.
fn description(edition: Edition) -> String {
    let (head, units) = (
        "canHandleVariableCommunicationStepSize=\"true\"",
        "<UnitDefinitions><Unit name=\"m/s\"><BaseUnit m=\"1\" s=\"-1\"/></Unit><Unit name=\"m\"><BaseUnit m=\"1\"/></Unit><Unit name=\"1/m\"><BaseUnit m=\"-1\"/></Unit></UnitDefinitions>",
    );
    // Name, number, causality, type of 2.0 and of 3.0, attributes.
    let variables = [
        ("vEgo", 0, "input", "Real", "Float64", "start=\"0\""),
        ("vSet", 1, "input", "Real", "Float64", "unit=\"m/s\" start=\"0\""),
        ("x", 2, "input", "Real", "Float64", "unit=\"m\" start=\"0\""),
        ("y", 3, "input", "Real", "Float64", "start=\"0\""),
        ("present", 4, "input", "Boolean", "Boolean", "start=\"false\""),
        ("gap", 5, "parameter", "Real", "Float64", "start=\"5\" min=\"0\" max=\"100\""),
        ("axReq", 6, "output", "Real", "Float64", ""),
        ("kind", 7, "parameter", "String", "String", "start=\"good\""),
        ("levels", 8, "parameter", "Integer", "UInt16", "start=\"0\""),
        ("kappa", 9, "output", "Real", "Float64", "unit=\"1/m\""),
    ];
    let lines = variables.map(|(name, number, causality, two, three, more)| match edition {
        Edition::Two => format!(
            "<ScalarVariable name=\"{name}\" valueReference=\"{number}\" causality=\"{causality}\"><{two} {more}/></ScalarVariable>\n"
        ),
        Edition::Three => {
            format!("<{three} name=\"{name}\" valueReference=\"{number}\" causality=\"{causality}\" {more}/>\n")
        }
    });
    let (version, token) = match edition {
        Edition::Two => ("2.0", "guid"),
        Edition::Three => ("3.0", "instantiationToken"),
    };
    format!(
        "<fmiModelDescription fmiVersion=\"{version}\" modelName=\"Braker\" version=\"2.1\" {token}=\"good\">
<CoSimulation modelIdentifier=\"unit\" {head}/>
{units}<ModelVariables>
{}</ModelVariables></fmiModelDescription>",
        lines.concat()
    )
}

/// The library that was built with these tests.
fn library() -> PathBuf {
    let name = format!("{}test_fmu{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    let own = std::env::current_exe().unwrap();
    let path = own.parent().unwrap().join(name);
    assert!(path.is_file(), "{} is built with the tests", path.display());
    path
}

fn zipped(edition: Edition, description: &str) -> Vec<u8> {
    zipped_with(edition, description, &fs::read(library()).unwrap())
}

fn zipped_with(edition: Edition, description: &str, library: &[u8]) -> Vec<u8> {
    let platform = match edition {
        Edition::Two if cfg!(all(target_os = "linux", target_arch = "x86_64")) => "linux64".to_string(),
        Edition::Two if cfg!(all(windows, target_arch = "x86_64")) => "win64".to_string(),
        Edition::Two if cfg!(all(target_os = "macos", target_arch = "x86_64")) => "darwin64".to_string(),
        _ if cfg!(target_os = "macos") => format!("{}-darwin", std::env::consts::ARCH),
        _ => format!("{}-{}", std::env::consts::ARCH, std::env::consts::OS),
    };
    let library_name = format!("binaries/{platform}/unit{}", std::env::consts::DLL_SUFFIX);
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, content) in [
        ("modelDescription.xml", description.as_bytes().to_vec()),
        (&library_name, library.to_vec()),
        ("resources/table.csv", b"1,2".to_vec()),
    ] {
        zip.start_file(name, SimpleFileOptions::default()).unwrap();
        zip.write_all(&content).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// The scenario with the unit in place of the program.
fn with_unit(text: &str, wired: &str) -> String {
    let mark = "environment \"TESTS_UNDER_TEST=child\"\n  parameter gap = 5 m in 1 m .. 30 m\n";
    let rest = text.split_once(mark).unwrap().1;
    format!("controller own {{\n{wired}{rest}")
}

fn in_folder(text: &str, wired: &str, edition: Edition, description: &str) -> tempfile::TempDir {
    let folder = super::in_folder(&with_unit(text, wired));
    fs::write(folder.path().join("own.fmu"), zipped(edition, description)).unwrap();
    folder
}

fn allowed(folder: &Path, arguments: &[&str]) -> Said {
    let mut all = vec!["meet.scn", "--allow-run", "--no-progress", "--json=out.json"];
    all.extend(arguments);
    run(folder, &all)
}

fn fingerprints_in(folder: &Path, arguments: &[&str]) -> Result<Vec<(String, String)>, Failed> {
    let said = allowed(folder, arguments);
    expect(said.code == Some(0), || said.text.clone())?;
    written_fingerprints(folder)
}

fn fingerprints(text: &str, wired: &str, edition: Edition) -> Result<Vec<(String, String)>, Failed> {
    fingerprints_in(in_folder(text, wired, edition, &description(edition)).path(), &["-j2"])
}

/// Runs of many gaps, in which nothing settles.
fn runs() -> String {
    many("", "period 100 ms")
}

/// The same bits as a process, for both editions, with any number of threads: each run has an instance of its own.
pub fn a_unit_decides_as_its_native_twin() -> Outcome {
    let native = super::fingerprints(&runs(), &["-j1"])?;
    for edition in EDITIONS {
        let folder = in_folder(&runs(), WIRED, edition, &description(edition));
        for threads in ["-j1", "-j3"] {
            let found = fingerprints_in(folder.path(), &[threads])?;
            expect(found == native, || format!("{threads}: {found:#?} {native:#?}"))?;
        }
        let other = fingerprints(&runs(), &WIRED.replace("kind = \"good\"", "kind = \"level\""), edition)?;
        expect(other != native, || "neither texts nor whole numbers come through".to_string())?;
    }
    Ok(())
}

/// A curvature is an output that may be wired besides.
pub fn a_unit_steers_as_its_native_twin() -> Outcome {
    let native = super::fingerprints(&many("kind=steers", "period 100 ms"), &[])?;
    let wired = WIRED.replace("kind = \"good\"", "kind = \"steers\"");
    let steers = format!("{wired}  output curvature = \"kappa\"\n");
    for edition in EDITIONS {
        let found = fingerprints(&runs(), &steers, edition)?;
        expect(found == native, || format!("{found:#?} {native:#?}"))?;
        let other = fingerprints(&runs(), &wired, edition)?;
        expect(other != native, || "it steers though nothing is wired".to_string())?;
    }
    Ok(())
}

/// What an instance remembers is its own, whichever runs it is made beside and after: sixteen at once, and one.
pub fn instances_share_nothing() -> Outcome {
    let summing = WIRED.replace("kind = \"good\"", "kind = \"sums\"");
    for (edition, threads) in EDITIONS.into_iter().zip([["-j1", "-j2"], ["-j2", "-j1"]]) {
        let several = fingerprints(&runs(), &summing, edition)?;
        let once = description(edition)
            .replace("<CoSimulation ", "<CoSimulation canBeInstantiatedOnlyOncePerProcess=\"true\" ");
        // One that cannot be made twice says so itself.
        let token = once.replace("=\"good\">", "=\"once\">");
        for (description, threads) in [once, token].iter().zip(threads) {
            let folder = in_folder(&runs(), &summing, edition, description);
            let found = fingerprints_in(folder.path(), &[threads])?;
            expect(found == several, || format!("{threads}: {found:#?} {several:#?}"))?;
        }
        let other = fingerprints(&runs(), WIRED, edition)?;
        expect(other != several, || "nothing is remembered".to_string())?;
        // What goes on from one run to another is found out.
        let carrying = WIRED.replace("kind = \"good\"", "kind = \"carries\"");
        let folder = in_folder(&runs(), &carrying, edition, &description(edition));
        let said = allowed(folder.path(), &["--verify-runs=all", "-j1"]);
        expect(said.text.contains("W1102"), || said.text.clone())?;
    }
    Ok(())
}

pub fn what_a_unit_must_not_is_an_error_of_the_run() -> Outcome {
    // With one thread both runs are in one request; with two, each thread waits for the only process.
    for (edition, threads) in EDITIONS.into_iter().zip(["-j1", "-j2"]) {
        for (kind, fault, words) in [
            ("error", "refused", "error: lane is None"),
            ("discard", "refused", "discard"),
            ("fatal", "refused", "fatal: out of %s"),
            ("uninitialised", "refused", "it cannot be initialised: error"),
            ("nan", "bad_value", "an acceleration of NaN m/s²"),
            ("huge", "bad_value", "an acceleration of 1000000000 m/s²"),
            ("aborts", "exited", "SIGABRT"),
            ("hangs", "timeout", "no answer within 0.5 s"),
        ] {
            if kind == "aborts" && !cfg!(unix) {
                continue;
            }
            let wired = WIRED.replace("kind = \"good\"", &format!("kind = \"{kind}\""));
            // One run for each gap: a request with more runs may take longer.
            let text = scenario("", "period 100 ms\n  answers within 0.5 s\n  at most 1 process")
                .replace("later in [0 s, 0.2 s]", "later in [0 s]")
                .replace("  expect {", "  vary own_gap in [5 m, 8 m]\n  expect {")
                .replace("controller own;", "controller own { gap: own_gap };");
            let folder = in_folder(&text, &wired, edition, &description(edition));
            let said = allowed(folder.path(), &[threads]);
            let what = format!("{fault}: ");
            expect_all(&said, 100, &["`av` cannot decide", &what, words])?;
            // Only those that misbehave: gaps of 8 m, or all.
            let json: serde_json::Value =
                serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
            let trials = json["suites"][0]["trials"].as_array().unwrap();
            let blamed = |gap: f64| {
                let trial = trials.iter().find(|one| one["variation"]["own_gap"] == gap).unwrap();
                trial["verdict"] == "error"
            };
            expect(blamed(8.0) && blamed(5.0) == (kind == "uninitialised"), || said.text.clone())?;
        }
    }
    let ends = WIRED.replace("kind = \"good\"", "kind = \"ends\"");
    let folder = in_folder(&runs(), &ends, Edition::Three, &description(Edition::Three));
    expect_all(&allowed(folder.path(), &[]), 100, &["it wants the simulation to end"])?;
    let early = WIRED.replace("kind = \"good\"", "kind = \"early\"");
    let folder = in_folder(&runs(), &early, Edition::Three, &description(Edition::Three));
    expect_all(&allowed(folder.path(), &[]), 100, &["it came back before its step was over"])
}

/// That another run of a request fails changes no bit of the others: nobody steps twice.
pub fn who_shares_a_request_with_a_failing_run_steps_once() -> Outcome {
    let bits = |kind: &str, text: &str| -> Result<Vec<(String, String)>, Failed> {
        let wired = WIRED.replace("kind = \"good\"", &format!("kind = \"{kind}\""));
        let folder = in_folder(text, &wired, Edition::Two, &description(Edition::Two));
        allowed(folder.path(), &["-j1"]);
        let json: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
        let mut found = Vec::new();
        gather(&json, &mut found);
        found.retain(|(key, _)| !key.contains("own_gap=8"));
        found.sort();
        found.dedup();
        Ok(found)
    };
    // All in one trial would hide what the others came to.
    let text = runs().replace("repeat 3", "repeat 1");
    let (good, bad) = (bits("good", &text)?, bits("error", &text)?);
    expect(!good.is_empty() && good == bad, || format!("{good:#?} {bad:#?}"))
}

/// What a library prints gets between nobody.
pub fn what_a_unit_prints_is_log() -> Outcome {
    let printing = WIRED.replace("kind = \"good\"", "kind = \"prints\"");
    let native = super::fingerprints(&runs(), &["-j1"])?;
    for edition in EDITIONS {
        let found = fingerprints(&runs(), &printing, edition)?;
        expect(!cfg!(unix) || found == native, || format!("{found:#?} {native:#?}"))?;
    }
    Ok(())
}

/// Numbers are in the units that are said, by the file or by the unit, and by both as one.
pub fn units_are_converted_as_they_are_said() -> Outcome {
    let own = description(Edition::Two);
    let speed = "<BaseUnit m=\"1\" s=\"-1\"/>";
    let slow = "<BaseUnit m=\"1\" s=\"-1\" factor=\"10\"/>";
    let y = "name=\"y\" valueReference=\"3\" causality=\"input\"><Real ";
    assert!(own.contains(speed) && own.contains(y));
    for (wired, said, strongest) in [
        (WIRED.to_string(), own.clone(), 3.05),
        // Both say that a metre is one.
        (WIRED.to_string(), own.replace(y, &format!("{y}unit=\"m\" ")), 3.05),
        (WIRED.replace("\"axReq\" in m/s^2", "\"axReq\" in g"), own.clone(), 3.05 * 9.806_65),
        // 500 cm where the unit has 5 m.
        (
            WIRED.replace("as \"gap\" in m", "as \"gap\" in cm"),
            own.replace("max=\"100\"", "max=\"10000\""),
            8.0,
        ),
        // It takes 30 km/h for 30 m/s, at first; the metric looks at two decisions together.
        (WIRED.replace("\"vEgo\" in m/s", "\"vEgo\" in km/h"), own.clone(), 9.858),
        // It wants a tenth of the speed.
        (WIRED.to_string(), own.replace(speed, slow), 3.656),
    ] {
        let text = runs().replace("[5 m, 8 m, 20 m]", "[5 m]").replace("repeat 3", "repeat 1");
        let text = text.replace("<= 9 m/s^2", "<= 100 m/s^2");
        let folder = in_folder(&text, &wired, Edition::Two, &said);
        expect_all(&allowed(folder.path(), &[]), 0, &[])?;
        let json: serde_json::Value =
            serde_json::from_str(&fs::read_to_string(folder.path().join("out.json"))?)?;
        let trials = json["suites"][0]["trials"].as_array().unwrap().iter();
        let found = trials.map(|one| one["runs"][0]["metrics"]["max_deceleration"].as_f64().unwrap());
        let found = found.fold(0.0, f64::max);
        expect((found - strongest).abs() <= 0.01, || format!("{found} instead of {strongest} m/s²"))?;
    }
    Ok(())
}

/// What is not wired as it is meant is said before anything runs, at its place.
pub fn what_cannot_be_wired_is_said_before_anything_runs() -> Outcome {
    let own = description(Edition::Two);
    let line = |wired: &str, part: &str| 2 + wired.lines().position(|line| line.contains(part)).unwrap();
    let file = |from: &str, to: &str| (WIRED.replace(from, to), own.clone());
    let unit = |from: &str, to: &str| {
        assert!(own.contains(from), "{from}");
        (WIRED.to_string(), own.replace(from, to))
    };
    for ((wired, said), part, words) in [
        (file("\"vEgo\" in", "\"vEgoo\" in"), "vEgoo", "it has no variable `vEgoo` (nearest: `vEgo`)"),
        (file("\"vEgo\" in m/s", "\"axReq2\" in m/s"), "axReq2", "no variable `axReq2`"),
        (
            file("= \"x\"", "= \"gap\"").0.replace("as \"gap\" in m", "as \"x\" in m").into_pair(&own),
            "= \"gap\"",
            "`gap` is a parameter",
        ),
        (file("\"axReq\" in m/s^2", "\"extra\" in m/s^2"), "\"extra\"", "no variable `extra`"),
        (
            file("\"vSet\"", "\"vSet\" in km/h"),
            "vSet",
            "has its variable `vSet` in `m/s`, the file in `km/h`",
        ),
        (
            file("\"y\" in m", "\"y\""),
            "= \"y\"",
            "neither file nor FMU says in which unit its variable `y` is",
        ),
        (file("\"axReq\" in m/s^2", "\"axReq\""), "axReq", "neither file nor FMU says"),
        (
            unit("<BaseUnit m=\"1\" s=\"-1\"/>", "<BaseUnit m=\"1\"/>"),
            "vSet",
            "`vSet` is in `m/s`, and `cruise_speed` a speed",
        ),
        (
            unit("<BaseUnit m=\"1\" s=\"-1\"/>", "<BaseUnit m=\"1\" s=\"-1\" offset=\"3\"/>"),
            "vSet",
            "`vSet` is in `m/s`",
        ),
        (
            (
                WIRED.to_string(),
                own.replace("m/s\"", "km/h\"")
                    .replace("<BaseUnit m=\"1\" s=\"-1\"/>", "<BaseUnit m=\"1\" s=\"-1\" factor=\"0.277\"/>"),
            ),
            "vSet",
            "the FMU says that its unit `km/h` is 0.277 m/s",
        ),
        (
            unit("<BaseUnit m=\"1\" s=\"-1\"/>", "<BaseUnit kg=\"1\" m=\"1\" s=\"-1\"/>"),
            "vSet",
            "`vSet` is in `m/s`",
        ),
        (
            unit(
                "\"axReq\" valueReference=\"6\" causality=\"output\"",
                "\"axReq\" valueReference=\"6\" causality=\"local\"",
            ),
            "axReq",
            "`axReq` is nothing that is set or asked",
        ),
        (
            unit(
                "\"gap\" valueReference=\"5\" causality=\"parameter\"",
                "\"gap\" valueReference=\"5\" causality=\"parameter\" variability=\"constant\"",
            ),
            "gap",
            "`gap` is constant",
        ),
        (
            unit("\"x\" valueReference=\"2\"", "\"x\" valueReference=\"0\""),
            "= \"x\"",
            "`x` is another name of a variable",
        ),
        (
            unit("causality=\"output\"><Real", "causality=\"output\"><Integer"),
            "axReq",
            "`axReq` is of the type Int32",
        ),
        (unit("name=\"m/s\"><BaseUnit m=\"1\" s=\"-1\"/>", "name=\"m/s\">"), "vSet", ""),
        (
            unit(
                "</ModelVariables>",
                "<ScalarVariable name=\"lead\" valueReference=\"99\" causality=\"input\"><Real/></ScalarVariable></ModelVariables>",
            ),
            "controller",
            "nothing is told to its input `lead`",
        ),
        (
            unit(
                "canHandleVariableCommunicationStepSize=\"true\"/>",
                "canHandleVariableCommunicationStepSize=\"false\"/><DefaultExperiment stepSize=\"0.03\"/>",
            ),
            "controller",
            "works in steps of 0.03 s, of which the period of 0.1 s is no multiple",
        ),
    ] {
        let folder = in_folder(&runs(), &wired, Edition::Two, &said);
        let found = allowed(folder.path(), &[]);
        if words.is_empty() {
            // By its name alone it is the unit that the file means.
            expect(found.code == Some(0), || found.text.clone())?;
            continue;
        }
        let place = format!("meet.scn:{}", if part == "controller" { 1 } else { line(&wired, part) });
        expect_all(&found, 3, &["E1110", words, &place])?;
        // Nobody has to read the unit to check what is said of it.
        expect_all(&run(folder.path(), &["check", "meet.scn"]), 0, &[])?;
    }
    // One that works in steps of its own needs to know the period, and takes a multiple.
    let fixed = own
        .replace("SimulationStepSize", "")
        .replace("=\"true\"/>", "=\"false\"/><DefaultExperiment stepSize=\"0.05\"/>");
    let folder = in_folder(&runs(), WIRED, Edition::Two, &fixed);
    expect_all(&allowed(folder.path(), &[]), 0, &[])?;
    let folder = in_folder(&many("", ""), WIRED, Edition::Two, &fixed);
    expect_all(&allowed(folder.path(), &[]), 3, &["E1110", "no `period` is said"])
}

/// A text with the description beside it.
trait IntoPair {
    fn into_pair(self, other: &str) -> (String, String);
}

impl IntoPair for String {
    fn into_pair(self, other: &str) -> (String, String) {
        (self, other.to_string())
    }
}

/// An input that stays at its own start value is told of, and one of which the file makes a parameter is set.
pub fn inputs_that_nobody_tells_are_named() -> Outcome {
    for edition in EDITIONS {
        let unwired = WIRED.replace("  input object1.y = \"y\" in m\n", "");
        let folder = in_folder(&runs(), &unwired, edition, &description(edition));
        expect_all(&allowed(folder.path(), &[]), 0, &["W1101", "`own` also has `y` (0"])?;
        let held = WIRED
            .replace("input object1.y = \"y\" in m", "parameter y = 100 m in 0 m .. 100 m as \"y\" in m");
        let (far, near) = (fingerprints(&runs(), &held, edition)?, fingerprints(&runs(), WIRED, edition)?);
        expect(far != near, || "what the file sets is not set".to_string())?;
    }
    Ok(())
}

/// File and unit must agree on parameters as file and program must.
pub fn parameters_are_those_of_the_unit() -> Outcome {
    for edition in EDITIONS {
        for (from, to, words) in [
            ("gap = 5 m in 1 m .. 30 m", "gap = 5 m in 1 m .. 300 m", "E1108"),
            ("level = 1 in whole 0 .. 9", "level = 1 in 0 .. 9", "E1108"),
            ("kind = \"good\"", "kind = true", "E1108"),
        ] {
            let folder = in_folder(&runs(), &WIRED.replace(from, to), edition, &description(edition));
            expect_all(&allowed(folder.path(), &[]), 3, &[words])?;
        }
    }
    // Decisions that fall beside the steps of the simulation would be told a time that is another.
    let text = many("", "period 30 ms");
    let folder = in_folder(&text, WIRED, Edition::Two, &description(Edition::Two));
    expect_all(
        &allowed(folder.path(), &[]),
        100,
        &["a period of 0.03 s is no multiple of the simulation step"],
    )
}

pub fn what_is_no_unit_is_said_before_anything_runs() -> Outcome {
    let own = description(Edition::Two);
    for (description, words) in [
        (own.replace("fmiVersion=\"2.0\"", "fmiVersion=\"1.0\""), "is of FMI `1.0`"),
        (own.replace("CoSimulation", "ModelExchange"), "export the FMU for co-simulation"),
        (own.replace("modelIdentifier=\"unit\"", "modelIdentifier=\"other\""), "no library for this machine"),
        (own.replace("</ModelVariables>", ""), "is no XML"),
    ] {
        let folder = in_folder(&runs(), WIRED, Edition::Two, &description);
        expect_all(&allowed(folder.path(), &[]), 3, &["E1106", words, "meet.scn:1"])?;
    }
    let folder = in_folder(&runs(), WIRED, Edition::Two, &own);
    fs::write(folder.path().join("own.fmu"), "PK")?;
    expect_all(&allowed(folder.path(), &[]), 3, &["E1106", "no archive"])?;
    fs::remove_file(folder.path().join("own.fmu"))?;
    expect_all(&allowed(folder.path(), &[]), 3, &["E1106", "own.fmu cannot be read"])?;
    // A unit that makes no instance says so for each run.
    let refusing = own.replace("guid=\"good\"", "guid=\"refuses\"");
    let folder = in_folder(&runs(), WIRED, Edition::Two, &refusing);
    expect_all(&allowed(folder.path(), &[]), 100, &["refused: it makes no instance"])?;
    let folder = in_folder(&runs(), WIRED, Edition::Two, &own);
    fs::write(folder.path().join("own.fmu"), zipped_with(Edition::Two, &own, b"no code"))?;
    expect_all(&allowed(folder.path(), &[]), 3, &["E1107", "it wrote: its library is not loaded: "])?;
    // One of 3.0 is not taken for one of 2.0, although both are in the library.
    let found = zipped(Edition::Two, &description(Edition::Three));
    let folder = in_folder(&runs(), WIRED, Edition::Two, &own);
    fs::write(folder.path().join("own.fmu"), found)?;
    expect_all(&allowed(folder.path(), &[]), 3, &["E1106", "no library for this machine"])
}

/// A unit runs once its user has allowed it, as it is: another content is asked for again. What looks at the file runs nothing.
pub fn a_unit_needs_permission_for_its_content() -> Outcome {
    let folder = in_folder(&runs(), WIRED, Edition::Two, &description(Edition::Two));
    let path = folder.path();
    for command in [&["check", "meet.scn"][..], &["list", "meet.scn"], &["models", "own", "meet.scn"]] {
        expect_all(&run(path, command), 0, &[])?;
    }
    let refused = run(path, &["meet.scn"]);
    expect_all(&refused, 3, &["E1105", "`own` wants to run `fmu own.fmu`"])?;
    expect_all(&run(path, &["try", "meet.scn"]), 3, &["E1105"])?;
    expect_all(&run(path, &["allow", "meet.scn"]), 0, &["may run what is in", "own.fmu"])?;
    expect_all(&run(path, &["meet.scn", "--no-progress"]), 0, &[])?;
    expect_all(&run(path, &["try", "meet.scn"]), 0, &["Braker 2.1", "nothing is wrong"])?;
    fs::write(path.join("own.fmu"), zipped(Edition::Two, &description(Edition::Two).replace("2.1", "2.2")))?;
    expect_all(&run(path, &["meet.scn"]), 3, &["E1105"])?;
    expect_all(&run(path, &["allow", "meet.scn"]), 0, &[])?;
    expect_all(&run(path, &["meet.scn", "--no-progress"]), 0, &[])?;
    // Wiring and limits say nothing of what runs.
    let text = fs::read_to_string(path.join("meet.scn"))?;
    fs::write(path.join("meet.scn"), text.replace("gap = 5 m", "gap = 6 m"))?;
    expect_all(&run(path, &["meet.scn", "--no-progress"]), 0, &[])?;
    expect_all(&run(path, &["allow", "--revoke", "meet.scn"]), 0, &["took back"])?;
    expect_all(&run(path, &["meet.scn"]), 3, &["E1105"])
}

/// Nothing of a unit is left where it was unpacked.
#[cfg(unix)]
pub fn what_was_unpacked_is_gone() -> Outcome {
    what_is_killed_leaves_is_swept()?;
    let folder = in_folder(&scenario("", "period 100 ms"), WIRED, Edition::Two, &description(Edition::Two));
    let temporary = tempfile::tempdir()?;
    let arguments = ["meet.scn", "--allow-run", "--no-progress"];
    let status = super::runner(folder.path(), &arguments).env("TMPDIR", temporary.path()).output()?;
    let left = fs::read_dir(temporary.path())?.count();
    expect(status.status.code() == Some(0) && left == 0, || format!("{left} {status:?}"))
}

/// A runner that is ended from one moment to the next leaves what it has unpacked, and the next one removes that; not what is another's.
#[cfg(unix)]
fn what_is_killed_leaves_is_swept() -> Outcome {
    let slow = scenario("", "period 100 ms").replace("expect {", "repeat 100000\n  expect {");
    let folder = in_folder(&slow, WIRED, Edition::Two, &description(Edition::Two));
    let temporary = tempfile::tempdir()?;
    let others = temporary.path().join("scenario-runner-fmu-others");
    fs::create_dir(&others)?;
    let arguments = ["meet.scn", "--allow-run", "--no-progress", "-j1"];
    let start = || {
        let mut runner = super::runner(folder.path(), &arguments);
        runner.env("TMPDIR", temporary.path()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()
    };
    let unpacked = || -> Vec<PathBuf> {
        let all = fs::read_dir(temporary.path()).unwrap().map(|entry| entry.unwrap().path());
        all.filter(|path| path.join("plan.json").exists()).collect()
    };
    let wait = |count: usize| {
        let begun = Instant::now();
        while unpacked().len() < count && begun.elapsed() < Duration::from_secs(20) {
            std::thread::sleep(Duration::from_millis(20));
        }
        unpacked()
    };
    let mut killed = start()?;
    let left = wait(1);
    killed.kill()?;
    killed.wait()?;
    expect(left.len() == 1 && unpacked() == left, || format!("{left:?} {:?}", unpacked()))?;
    // The next removes it, and leaves alone what a third one needs.
    let mut living = start()?;
    let begun = Instant::now();
    while (unpacked() == left || unpacked().is_empty()) && begun.elapsed() < Duration::from_secs(20) {
        std::thread::sleep(Duration::from_millis(20));
    }
    let own = unpacked();
    let mut third = start()?;
    let both = wait(2);
    for runner in [&mut living, &mut third] {
        runner.kill()?;
        runner.wait()?;
    }
    expect(own.len() == 1 && own != left, || format!("{left:?} was not swept: {own:?}"))?;
    expect(both.len() == 2 && both.contains(&own[0]), || format!("{own:?} is gone: {both:?}"))?;
    expect(others.exists(), || "another's folder was removed".to_string())
}

/// Suites as tests of a project load units in processes of that very program.
pub fn tests_of_a_project_run_units() -> Outcome {
    for edition in [Edition::Two, Edition::Three] {
        let folder = in_folder(&scenario("", "period 100 ms"), WIRED, edition, &description(edition));
        fs::write(folder.path().join("gated.suite"), "suite gated {\n  scenarios \"meet.scn\"\n}\n")?;
        let output = Command::new(std::env::current_exe()?)
            .current_dir(folder.path())
            .env(super::ROLE, "tests")
            .env("TESTS_VERIFY", "all")
            .env("XDG_CONFIG_HOME", folder.path().join("config"))
            .output()?;
        let text = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
        expect_all(&Said { code: output.status.code(), text }, 0, &["0 failed"])?;
    }
    Ok(())
}
