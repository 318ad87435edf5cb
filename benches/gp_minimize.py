"""The reference beside `benches/optimisation_goals.rs`: scikit-optimize 0.10.2's gp_minimize on the same test functions.

    python3 -m venv target/reference && target/reference/bin/pip install scikit-optimize==0.10.2
    OMP_NUM_THREADS=1 nice target/reference/bin/python benches/gp_minimize.py --out target/gp_minimize.jsonl
    cargo bench --bench optimisation_goals

One JSON line per run: problem, seed, the 60 points in evaluation order, the value each was told, and the CPU seconds of the
whole run. Nothing is judged here: the Rust program reads the file and treats both methods alike. A run already in the file
is skipped, so an interrupted session continues where it stopped.

With `--encounters PROGRAM` the objective is simulated: PROGRAM is the built `benches/worst_arrival.rs`, which says how.
"""

import argparse
import json
import math
import os
import subprocess
import time
import warnings

os.environ.setdefault("OMP_NUM_THREADS", "1")  # two BLAS threads make the reference six times slower

import numpy as np
from skopt import gp_minimize

EVALUATIONS = 60
INITIAL = 15
PENALTY = 1000.0  # the paper's form: one large constant for an infeasible candidate


def logistic(x):
    return 1.0 / (1.0 + math.exp(-x))


def gramacy(x, noise):
    z = 0.5 + (x[0] - 6.0) / 6.0
    return math.sin(10.0 * math.pi * z) / (2.0 * z) + (z - 1.0) ** 4 + 0.1 * noise()


def step(x, noise):
    p = logistic((x[0] - 9.5) / 0.15)
    q = logistic((x[0] - 9.5) / 0.4)
    f = (1.0 - p) * (3.6 + 0.05 * (x[0] - 6.0)) + p * (1.2 + 0.55 * max(0.0, x[0] - 9.5))
    return f + (0.1 + 2.0 * q * (1.0 - q)) * noise()


def well(x, noise):
    u = (x[0] - 6.0) / 12.0
    return 3.0 + 0.4 * math.sin(4.0 * math.pi * u) - 2.5 * math.exp(-((x[0] - 14.3) ** 2) / 0.08) + 0.15 * noise()


def branin(x, noise):
    a = x[1] - 5.1 / (4.0 * math.pi**2) * x[0] ** 2 + 5.0 / math.pi * x[0] - 6.0
    return a * a + 10.0 * (1.0 - 1.0 / (8.0 * math.pi)) * math.cos(x[0]) + 10.0 + 2.0 * noise()


ALPHA = [1.0, 1.2, 3.0, 3.2]
A = [
    [10, 3, 17, 3.5, 1.7, 8],
    [0.05, 10, 17, 0.1, 8, 14],
    [3, 3.5, 1.7, 10, 17, 8],
    [17, 8, 0.05, 10, 0.1, 14],
]
P = [
    [0.1312, 0.1696, 0.5569, 0.0124, 0.8283, 0.5886],
    [0.2329, 0.4135, 0.8307, 0.3736, 0.1004, 0.9991],
    [0.2348, 0.1451, 0.3522, 0.2883, 0.3047, 0.6650],
    [0.4047, 0.8828, 0.8732, 0.5743, 0.1091, 0.0381],
]


def hartmann6_truth(x):
    return -sum(
        ALPHA[i] * math.exp(-sum(A[i][j] * (x[j] - P[i][j]) ** 2 for j in range(6))) for i in range(4)
    )


def hartmann6(x, noise):
    return hartmann6_truth(x) + 0.1 * noise()


def penalised(objective, margins):
    return objective if all(margin >= 0.0 for margin in margins) else PENALTY


def braking(x, noise):
    d = x[0]
    objective = 20.0 / d + 0.04 * d + 0.05 * noise()
    return penalised(objective, [0.1 * d - 1.4 + 0.1 * noise(), 2.5 - 50.0 / d + 0.1 * noise()])


def toy2(x, noise):
    objective = x[0] + x[1] + 0.05 * noise()
    c1 = x[0] + 2.0 * x[1] + 0.5 * math.sin(2.0 * math.pi * (x[0] ** 2 - 2.0 * x[1])) - 1.5 + 0.05 * noise()
    c2 = 1.5 - x[0] ** 2 - x[1] ** 2 + 0.05 * noise()
    return penalised(objective, [c1, c2])


def hartmann6_sum(x, noise):
    objective = hartmann6_truth(x) + 0.1 * noise()
    return penalised(objective, [3.0 - sum(x) + 0.1 * noise()])


PROBLEMS = {
    "gramacy": (gramacy, [(6.0, 18.0)]),
    "step": (step, [(6.0, 18.0)]),
    "well": (well, [(6.0, 18.0)]),
    "branin": (branin, [(-5.0, 10.0), (0.0, 15.0)]),
    "hartmann6": (hartmann6, [(0.0, 1.0)] * 6),
    "braking": (braking, [(5.0, 60.0)]),
    "toy2": (toy2, [(0.0, 1.0)] * 2),
    "hartmann6_sum": (hartmann6_sum, [(0.0, 1.0)] * 6),
}


PEOPLE = 20
UNDEFINED = 60.0  # s: what an undefined time counts as, the end of the scenario


def encounters(program, repetitions, out):
    """The worst arrival time of each person: minimises the simulated post-encroachment time over the time to arrival."""
    done = set()
    if os.path.exists(out):
        with open(out) as lines:
            done = {(run["individual"], run["repetition"]) for run in map(json.loads, lines)}
    server = subprocess.Popen([program, "serve"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    for repetition in range(repetitions):
        for individual in range(PEOPLE):
            if (individual, repetition) in done:
                continue
            values = []

            def objective(x):
                server.stdin.write(json.dumps([individual, float(x[0]), repetition, len(values)]) + "\n")
                server.stdin.flush()
                values.append(json.loads(server.stdout.readline()))
                return UNDEFINED if values[-1] is None else values[-1]

            start = time.process_time()
            result = gp_minimize(
                objective,
                [(6.0, 18.0)],
                n_calls=EVALUATIONS,
                n_initial_points=INITIAL,
                random_state=1000 * repetition + individual,
            )
            run = {
                "individual": individual,
                "repetition": repetition,
                "points": [float(point[0]) for point in result.x_iters],
                "values": values,
                "cpu_s": time.process_time() - start,
            }
            with open(out, "a") as file:
                file.write(json.dumps(run) + "\n")
    server.stdin.close()
    server.wait()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", default="target/gp_minimize.jsonl")
    parser.add_argument("--seeds", type=int, default=40)
    parser.add_argument("--chunk", type=int, default=20, help="seeds of every problem before the next chunk")
    parser.add_argument("--problems", nargs="*", default=list(PROBLEMS))
    parser.add_argument("--encounters", metavar="PROGRAM", help="search simulated encounters instead")
    parser.add_argument("--repetitions", type=int, default=2, help="searches of each person, with --encounters")
    arguments = parser.parse_args()
    warnings.filterwarnings("ignore")
    if arguments.encounters:
        encounters(arguments.encounters, arguments.repetitions, arguments.out)
        return

    done = set()
    if os.path.exists(arguments.out):
        with open(arguments.out) as lines:
            done = {(run["problem"], run["seed"]) for run in map(json.loads, lines)}
    for first in range(0, arguments.seeds, arguments.chunk):
        for name in arguments.problems:
            function, dimensions = PROBLEMS[name]
            for seed in range(first, min(first + arguments.chunk, arguments.seeds)):
                if (name, seed) in done:
                    continue
                noise = np.random.default_rng(1000 + seed).standard_normal
                start = time.process_time()
                result = gp_minimize(
                    lambda x: float(function(x, noise)),
                    dimensions,
                    n_calls=EVALUATIONS,
                    n_initial_points=INITIAL,
                    random_state=seed,
                )
                run = {
                    "problem": name,
                    "seed": seed,
                    "points": [[float(c) for c in point] for point in result.x_iters],
                    "values": [float(value) for value in result.func_vals],
                    "cpu_s": time.process_time() - start,
                }
                with open(arguments.out, "a") as out:
                    out.write(json.dumps(run) + "\n")


if __name__ == "__main__":
    main()
