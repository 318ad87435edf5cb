"""A plan whose shares an engine makes: the reports of one machine. And what has failed or was killed is made by the same command."""

import os
import pathlib
import subprocess

from driver import expect, say

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
PROGRAM = REPOSITORY / "target/release/scenario-runner"


def run(*words, code=0, seconds=120, **environment):
    """What the program says on both streams."""
    done = subprocess.run(
        [PROGRAM, *map(str, words)], cwd=REPOSITORY, env={**os.environ, **environment}, capture_output=True, text=True, timeout=seconds, check=False
    )
    expect(done.returncode == code, f"{words}: exit code {done.returncode} instead of {code}:\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def reports(folder, name):
    return {kind: folder / f"{name}.{kind}" for kind in ("runs", "csv")}


def options(files):
    return [word for kind, path in files.items() for word in (f"--{kind}", path)]


def shares(folder, engine, *words, **environment):
    folder = pathlib.Path(folder).absolute() / "shares"
    folder.mkdir(parents=True)
    manifest, results = folder / "manifest.jsonl", folder / "results"
    run("plan", "suites/zebra.suite", "--out", manifest)
    execute = ["exec", manifest, "--on", engine, "--slices", 3, "--results", results, *words]
    said = run(*execute, **environment)
    expect("all 3 shares are made" in said, said)
    one, merged = reports(folder, "one"), reports(folder, "merged")
    run("suites/zebra.suite", "--no-progress", *options(one))
    run("merge", manifest, "--results", results, "--no-progress", *options(merged))
    for kind, path in one.items():
        expect(path.stat().st_size > 0 and path.read_bytes() == merged[kind].read_bytes(), f"{kind} differs")
    # What is cut off is not judged, and made again by the same command.
    batch = next(iter(sorted(results.glob("??/*.jsonl"))))
    whole = batch.read_bytes()
    batch.write_bytes(whole[: len(whole) // 2])
    run("merge", manifest, "--results", results, code=2)
    run(*execute, **environment)
    expect(batch.read_bytes() == whole, "a batch that was cut off is not what it was")
    say(f"a plan in 3 shares on {engine}: its reports are those of one machine, and what was cut off was made again")
