"""Runs one suite with the same controller in each language, one run and many at once, and compares all fingerprints."""

import json
import os
import shutil
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
SDK = os.path.dirname(HERE)


def fingerprints(value):
    """Those of all runs of a report, by their keys."""
    found = {}
    if isinstance(value, dict):
        if "fingerprint" in value:
            found[value["key"]] = value["fingerprint"]
        value = list(value.values())
    if isinstance(value, list):
        for one in value:
            found.update(fingerprints(one))
    return found


def command(words):
    """The statement of a controller that is started by these words."""
    return "command " + ", ".join(json.dumps(word) for word in words)


# The runs of these tell as well whether another encoding or another controller is the same.
SOME = "reach=25m"
SOME_RUNS = 22


def run(runner, folder, started, *words):
    """Runs the suite, or some of it, with a controller of which its declaration says this."""
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    shutil.copy(os.path.join(HERE, "meet.scn"), folder)
    with open(os.path.join(folder, "own.scn"), "w") as file:
        for name in ("own", "own_too"):
            says = f"{started}; period 100 ms; parameter braking_distance = 25 m in 1 m .. 60 m"
            file.write(f"controller {name} {{ {says} }}\n")
    said = subprocess.run(
        [runner, "meet.scn", *words, "--allow-run", "--no-progress", "-j2", "--json=out.json"], cwd=folder, capture_output=True, text=True
    )
    assert said.returncode == 0, f"{started}: exit code {said.returncode}\n{said.stdout}{said.stderr}"
    with open(os.path.join(folder, "out.json")) as file:
        return fingerprints(json.load(file))


def main(runner, folder):
    runner, folder = os.path.abspath(runner), os.path.abspath(folder)
    examples = os.path.join(SDK, "python", "examples")
    programs = {
        "JSON without a package": [sys.executable, os.path.join(examples, "brake_json.py")],
        "Python": [sys.executable, os.path.join(examples, "brake.py")],
        "numpy": [sys.executable, os.path.join(examples, "brake_vector.py")],
        "C": [os.path.join(os.path.dirname(folder), "brake")],
        "Rust": [os.path.join(os.path.dirname(folder), "rust", "release", "examples", "brake")],
    }
    known, first = None, None
    for name, words in programs.items():
        # What speaks plain JSON takes one run at once; the others are asked for one and for 64, packages of Python in both encodings.
        batches = [] if known is None else ["--runs-at-once=1", "--runs-at-once=64"]
        encodings = ["--encoding=json"] if name in ("Python", "numpy") else []
        variants = [*([batch] for batch in batches), *([batch, one] for one in encodings for batch in batches)]
        for more in variants or [[]]:
            some = [SOME] if more[1:] else []
            found = run(runner, os.path.join(folder, "run"), command(words + more), *some)
            if known is None:
                known, first = found, name
                assert len(set(known.values())) > 60, f"{len(set(known.values()))} runs differ from each other: the suite says too little"
            differing = [key for key in found if known.get(key) != found[key]]
            assert len(found) == (SOME_RUNS if some else len(known)) and not differing, f"{name} {more} is not {first} in {len(differing)} runs, such as {differing[:3]}"
            print(f"{name} {' '.join(more)}: the same {len(found)} fingerprints")
    module = os.path.join(os.path.dirname(folder), "rust", "wasm32-unknown-unknown", "release", "examples", "brake_module.wasm")
    found = run(runner, os.path.join(folder, "run"), f"wasm {json.dumps(module)}")
    differing = [key for key in known if known[key] != found.get(key)]
    assert known.keys() == found.keys() and not differing, f"the module is not {first} in {len(differing)} runs, such as {differing[:3]}"
    print(f"WebAssembly: the same {len(found)} fingerprints")
    # Another controller has others, or this would compare nothing.
    with open(os.path.join(examples, "brake.py")) as file:
        text = file.read()
    other = os.path.join(folder, "other.py")
    with open(other, "w") as file:
        file.write(text.replace("return -3.0", "return -3.0000001"))
    changed = run(runner, os.path.join(folder, "run"), command([sys.executable, other]), SOME)
    assert sum(changed[key] != known[key] for key in changed) > 20, "a controller that brakes otherwise has the same fingerprints"


if __name__ == "__main__":
    main(*sys.argv[1:])
