"""Runs one suite with a program in Python and with units that other tools have made of it, and compares all fingerprints."""

import json
import os
import shutil
import subprocess
import sys
import sysconfig
import zipfile

import fmu_brake
from same import HERE, SDK, SOME, SOME_RUNS, fingerprints

EDITIONS = {2: "pythonfmu", 3: "pythonfmu3"}


def library():
    """Of Python, for units that run Python and bring none."""
    path = os.path.join(sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("LDLIBRARY"))
    assert ".so" in path and os.path.exists(path), f"this Python has no shared library ({path}): units of pythonfmu do not run without"
    return path


def unit(folder, edition, name, **more):
    """Builds a unit into a folder."""
    module = os.path.join(folder, f"{name.lower()}.py")
    with open(module, "w") as file:
        file.write(fmu_brake.text(edition, name, **more))
    build = [sys.executable, "-m", EDITIONS[edition], "build", "-f", module, "-d", folder]
    said = subprocess.run(build, cwd=folder, capture_output=True, text=True)
    assert said.returncode == 0, said.stdout + said.stderr


def run(runner, folder, declared, *arguments):
    """Runs the suite with a controller of that declaration."""
    with open(os.path.join(HERE, "meet.scn")) as file:
        # Units of this controller cannot tell people from vehicles: the other vehicle is driven by one that ships.
        meet = file.read().replace("controller own_too", "controller idm_aeb")
    with open(os.path.join(folder, "meet.scn"), "w") as file:
        file.write(meet)
    with open(os.path.join(folder, "own.scn"), "w") as file:
        file.write(f"controller own {{\n  {declared}\n}}\n")
    out = os.path.join(folder, "out.json")
    if os.path.exists(out):
        os.remove(out)
    words = [runner, "meet.scn", "--no-progress", "--json=out.json", *arguments]
    said = subprocess.run(words, cwd=folder, capture_output=True, text=True, env=os.environ | {"XDG_CONFIG_HOME": folder})
    found = {}
    if os.path.exists(out):
        with open(out) as file:
            found = fingerprints(json.load(file))
    return said, found


def passed(runner, folder, declared, *arguments):
    said, found = run(runner, folder, declared, "--allow-run", *arguments)
    assert said.returncode == 0, f"exit code {said.returncode}\n{said.stdout}{said.stderr}"
    return found


def main(runner, folder, *options):
    quick = options == ("--quick",)
    assert quick or not options, options
    runner, folder = os.path.abspath(runner), os.path.abspath(folder)
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    words = json.dumps(sys.executable), json.dumps(os.path.join(SDK, "python", "examples", "brake.py"))
    program = f"command {', '.join(words)}\n  period 100 ms\n  parameter braking_distance = 25 m in 1 m .. 60 m"
    known = passed(runner, folder, program)
    assert len(set(known.values())) > 60, f"{len(set(known.values()))} runs differ from each other: the suite says too little"
    environment = json.dumps(f"LD_PRELOAD={library()}")
    for edition in (2,) if quick else EDITIONS:
        same_as_program(runner, folder, edition, environment, known)
        if not quick:
            others_differ(runner, folder, edition, environment, known)


def same_as_program(runner, folder, edition, environment, known):
    """A unit has the fingerprints of the program, and other ones if its speed is in another unit of measure."""
    name, tool = f"Brake{edition}", EDITIONS[edition]
    unit(folder, edition, name)
    found = passed(runner, folder, fmu_brake.declaration(name, environment), "-j2")
    differing = [key for key in known if known[key] != found.get(key)]
    assert known.keys() == found.keys() and not differing, f"{tool} is not Python in {len(differing)} runs, such as {differing[:3]}"
    faster = passed(runner, folder, fmu_brake.declaration(name, environment, unit="km/h"), SOME)
    assert len(faster) == SOME_RUNS, f"{len(faster)} runs are of {SOME}"
    assert sum(faster[key] != known[key] for key in faster) > 20, "a unit that gets its speed in km/h has the same fingerprints"
    print(f"{tool}: the same {len(found)} fingerprints as the program, and others with its speed in km/h")


def others_differ(runner, folder, edition, environment, known):
    """Another unit has other fingerprints; wrong units of measure, missing permission and exceptions are errors."""
    name, tool = f"Brake{edition}", EDITIONS[edition]
    unit(folder, edition, f"Other{edition}", braking="-3.0000001")
    changed = passed(runner, folder, fmu_brake.declaration(f"Other{edition}", environment), SOME)
    assert len(changed) == SOME_RUNS, f"{len(changed)} runs are of {SOME}"
    assert sum(changed[key] != known[key] for key in changed) > 20, "a unit that brakes otherwise has the same fingerprints"

    # A variable that is a length according to the unit is refused as a speed.
    with zipfile.ZipFile(os.path.join(folder, f"{name}.fmu")) as source:
        content = {one: source.read(one) for one in source.namelist()}
    text = content["modelDescription.xml"].decode()
    begin = text.index('name="speed"')
    end = text.index("</ScalarVariable>" if edition == 2 else "/>", begin)
    line = text[begin:end].replace('start="0', 'unit="m" start="0', 1)
    assert 'unit="m"' in line, line
    units = '<UnitDefinitions><Unit name="m"><BaseUnit m="1"/></Unit></UnitDefinitions><ModelVariables>'
    text = (text[:begin] + line + text[end:]).replace("<ModelVariables>", units, 1)
    with zipfile.ZipFile(os.path.join(folder, f"Metres{edition}.fmu"), "w") as target:
        for one, bytes_of in content.items():
            target.writestr(one, text.encode() if one == "modelDescription.xml" else bytes_of)
    said, found = run(runner, folder, fmu_brake.declaration(f"Metres{edition}", environment), "--allow-run")
    assert said.returncode == 3 and "E1110" in said.stderr and "`speed` is in `m`" in said.stderr and not found, said.stderr

    # Without permission nothing runs: this unit would make a file when its module is read.
    mark = os.path.join(folder, f"ran{edition}")
    unit(folder, edition, f"Marks{edition}", misdeed=f"open({mark!r}, 'w').close()")
    declared = fmu_brake.declaration(f"Marks{edition}", environment)
    said, found = run(runner, folder, declared, SOME)
    assert said.returncode == 3 and "E1105" in said.stderr and not found and not os.path.exists(mark), said.stderr
    passed(runner, folder, declared, SOME)
    assert os.path.exists(mark), "it would have made no file"

    # An exception is an error of its run, with the exception's text.
    unit(folder, edition, f"Raises{edition}", misdeed="if near: raise ValueError('lane is None')")
    said, found = run(runner, folder, fmu_brake.declaration(f"Raises{edition}", environment), SOME, "--allow-run", "-j2")
    assert said.returncode == 100 and "refused: " in said.stdout + said.stderr, said.stdout + said.stderr
    print(f"{tool}: other units, wrong units of measure, missing permission and exceptions are told apart")


if __name__ == "__main__":
    main(*sys.argv[1:])
