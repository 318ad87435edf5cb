//! Controllers that are WebAssembly modules: as their native twin, and within their bounds.

use std::fs;

use super::{Outcome, expect, expect_all, many, run, scenario, written_fingerprints};

/// The text of a module that brakes as the program of these tests does.
const BRAKES: &str = include_str!("brakes.wat");

/// The scenario with the module in place of the program, and a gap that the module does not read.
fn with_module(text: &str) -> String {
    let command = text.lines().next().unwrap();
    let rest = text.split_once("environment \"TESTS_UNDER_TEST=child\"\n").unwrap().1;
    assert!(command.starts_with("controller own {"), "{command}");
    format!("controller own {{\n  wasm \"own.wasm\"\n{rest}")
}

/// A folder with the scenario and the binary of the module with that text.
fn in_folder(text: &str, module: &str) -> tempfile::TempDir {
    in_folder_with(text, &wat::parse_str(module).expect("it is the text of a module"))
}

/// A folder with the scenario and those bytes as the file of the module.
fn in_folder_with(text: &str, module: &[u8]) -> tempfile::TempDir {
    let folder = super::in_folder(&with_module(text));
    fs::write(folder.path().join("own.wasm"), module).unwrap();
    folder
}

/// What runs come to: nothing is allowed to run.
fn fingerprints(text: &str, module: &str, threads: &str) -> Result<Vec<(String, String)>, super::Failed> {
    let folder = in_folder(text, module);
    let said = run(folder.path(), &["meet.scn", "--no-progress", "--json=out.json", threads]);
    expect(said.code == Some(0), || said.text.clone())?;
    written_fingerprints(folder.path())
}

/// The same bits as a process, in batches of any size, by any number of threads, without permission.
pub fn a_module_decides_as_its_native_twin() -> Outcome {
    let text = many("", "period 100 ms").replace("[5 m, 8 m, 20 m]", "[5 m]");
    let native = super::fingerprints(&text, &["-j1"])?;
    for (at_once, threads) in [("64", "-j1"), ("64", "-j3"), ("1", "-j2"), ("5", "-j1")] {
        let module = BRAKES.replace("runs_at_once\\\":64", &format!("runs_at_once\\\":{at_once}"));
        let shorter = 173 - (2 - at_once.len());
        let module = module.replace("(i32.const 173)", &format!("(i32.const {shorter})"));
        let found = fingerprints(&text, &module, threads)?;
        expect(found == native, || format!("{at_once} {threads}: {found:#?} {native:#?}"))?;
    }
    let other = fingerprints(&text, &BRAKES.replace("(f64.const -3)", "(f64.const -4)"), "-j1")?;
    expect(other != native, || "the module decides nothing".to_string())
}

pub fn what_a_module_must_not_is_an_error_of_the_run() -> Outcome {
    let late = |misdeed: &str| {
        let when = "(if (f64.gt (f64.load offset=8 (local.get $at)) (f64.const 0.5)) (then";
        BRAKES.replace(";; misdeed", &format!("{when} {misdeed}))"))
    };
    for (misdeed, fault, words) in [
        ("(unreachable)", "exited", "it trapped: "),
        ("(loop $l (br $l))", "timeout", "no answer within 100 million instructions"),
        ("(local.set $gives (f64.const nan))", "bad_value", "an acceleration of NaN m/s²"),
        ("(local.set $gives (f64.const 51))", "bad_value", "an acceleration of 51 m/s²"),
        ("(return (i32.const 0x7fffffff))", "garbage", "where it has no memory"),
        ("(return (i32.const 0))", "garbage", "is no answer"),
        ("(return (i32.const 2048))", "garbage", "it answered with a frame of 0 bytes"),
        ("(drop (i32.load (i32.const -8)))", "exited", "it trapped: "),
    ] {
        let folder = in_folder(&scenario("", ""), &late(misdeed));
        let what = format!("{fault}: ");
        let said = run(folder.path(), &["meet.scn", "--no-progress"]);
        expect_all(&said, 100, &["`av` cannot decide", &what, words, "scenario-runner replay"])?;
    }
    // What it asks for beyond its memory it does not get, and lives with that.
    let grows = late("(drop (memory.grow (i32.const 65535)))");
    let folder = in_folder(&scenario("", ""), &grows);
    expect_all(&run(folder.path(), &["meet.scn", "--no-progress"]), 0, &[])
}

pub fn what_is_no_module_is_said_before_anything_runs() -> Outcome {
    for (module, words) in [
        (
            BRAKES.replace("(module\n", "(module\n (import \"env\" \"now\" (func (result f64)))\n"),
            "it imports `env.now`",
        ),
        (BRAKES.replace("(export \"buffer\")", ""), "it exports no `buffer` from i32 to i32"),
        (BRAKES.replace("(memory (export \"memory\") 32)", "(memory 32)"), "it exports no `memory`"),
        (BRAKES.replace("\"memory\") 32)", "\"memory\") 1025)"), "it does not begin: "),
        (
            BRAKES.replace(
                "(func (export \"frame\")",
                "(func $s (loop $l (br $l))) (start $s)\n (func (export \"frame\")",
            ),
            "no answer within 100 million instructions",
        ),
    ] {
        let folder = in_folder(&scenario("", ""), &module);
        let said = run(folder.path(), &["meet.scn"]);
        expect_all(&said, 3, &["E1106", words, "meet.scn:1"])?;
    }
    let damaged = wat::parse_str(BRAKES)?.split_off(20);
    let binary = "own.wasm is not a WebAssembly module";
    let convert = "wasm-tools parse own.wasm -o module.wasm";
    let text = "own.wasm is the text of a WebAssembly module";
    for (bytes, words) in [
        (BRAKES.into(), [text, convert]),
        (format!("\n ;; of a compiler\n{BRAKES}").into_bytes(), [text, convert]),
        (b"import numpy".to_vec(), [binary, "core module"]),
        (Vec::new(), [binary, "core module"]),
        (damaged, [binary, "core module"]),
    ] {
        let folder = in_folder_with(&scenario("", ""), &bytes);
        expect_all(&run(folder.path(), &["meet.scn"]), 3, &["E1106", words[0], words[1], "meet.scn:1"])?;
    }
    let folder = in_folder(&scenario("", ""), &BRAKES.replace("\\\"protocol\\\":1", "\\\"protocol\\\":2"));
    expect_all(&run(folder.path(), &["meet.scn"]), 3, &["E1107", "it speaks protocol 2"])?;
    let folder = in_folder(&scenario("", ""), BRAKES);
    fs::remove_file(folder.path().join("own.wasm"))?;
    expect_all(&run(folder.path(), &["meet.scn"]), 3, &["E1106", "own.wasm cannot be read"])?;
    // Nobody has to read the module to check what is said of it.
    expect_all(&run(folder.path(), &["check", "meet.scn"]), 0, &[])
}
