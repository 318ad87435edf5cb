"""A plan whose shares an engine makes: the reports of one machine. And what has failed or was killed is made by the same command."""

import os
import pathlib
import subprocess

from driver import expect, say

PROGRAM = os.environ["SCENARIO_RUNNER"]
SUITE = """suite crossing {
  seed 11
  scenario walker {
    road { lane_width 4 m; speed_limit 30 km/h; crossing zebra }
    vehicle av { controller carla_behavior; speed 30 km/h }
    pedestrian walker { model carla_walker; start 2 m from kerb; appears when time_to_arrival(av) = tta }
    vary tta in [3 s, 4 s, 5 s, 6 s]
    repeat 400
    expect { max_deceleration <= 2 m/s^2; no collision }
  }
}
"""


def run(folder, *words, code=0, **environment):
    """What the program says on both streams."""
    done = subprocess.run(
        [PROGRAM, *map(str, words)], cwd=folder, env={**os.environ, **environment}, capture_output=True, text=True, timeout=120, check=False
    )
    expect(done.returncode == code, f"{words}: exit code {done.returncode} instead of {code}:\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def shares(folder, engine, *words, **environment):
    folder = pathlib.Path(folder).absolute() / "shares"
    folder.mkdir(parents=True)
    (folder / "crossing.suite").write_text(SUITE)
    run(folder, "plan", "crossing.suite", "--out", "manifest.jsonl")
    execute = ["exec", "manifest.jsonl", "--on", engine, "--slices", 3, "--results", "results", *words]
    said = run(folder, *execute, **environment)
    expect("all 3 shares are made" in said, said)
    merge = ["merge", "manifest.jsonl", "--results", "results", "--no-progress"]
    # It fails in both, by the same runs.
    run(folder, "crossing.suite", "--no-progress", "--runs", "one.jsonl", code=100)
    run(folder, *merge, "--runs", "merged.jsonl", code=100)
    one, merged = ((folder / name).read_bytes() for name in ("one.jsonl", "merged.jsonl"))
    expect(one.count(b"\n") == 1600 and one == merged, "the reports differ")
    # What is cut off is not judged, and made again by the same command.
    batch = min((folder / "results").glob("??/*.jsonl"))
    whole = batch.read_bytes()
    batch.write_bytes(whole[: len(whole) // 2])
    run(folder, *merge, code=2)
    run(folder, *execute, **environment)
    expect(batch.read_bytes() == whole, "a batch that was cut off is not what it was")
    say(f"a plan in 3 shares on {engine}: its reports are those of one machine, and what was cut off was made again")
