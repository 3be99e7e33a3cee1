#!/usr/bin/env python3
"""overfall beside SPlisHSPlasH and salva: the corner dam break of 130 000 particles, each program alone, in turn.

    python3 benches/peers/compare.py [--start 0] [--duration 0.5] [--rounds 1] [--threads 2] [--only PCISPH]…

Every row of the table is one method at one time step, over the first 0.5 s of the scene: forty minutes in all. The programs
take turns for so many rounds, the time of a program is the median of its rounds' means over the steps, and the ratio is
theirs over ours: above 1 ours is faster. A faster wrong answer is no win, so the density errors stand beside the times:
compression over all particles, its mean over the steps and its largest value, of the states that the steps begin from.

SPlisHSPlasH gives a particle 0.8 of its cube, so its block begins a fifth under the rest density and its solvers stop at their
least iterations until it has sunk together, after about 0.25 s: `--start 0.3 --duration 0.1` compares solvers at work. Its
PCISPH corrects pressures once more after the last prediction (as `last_correction` does), and at the least iterations of both
its solvers leave 0.4 to 0.6 times our mean error with our defaults. Against that PCISPH starts from half of the last step's
pressures here, IISPH takes three iterations at least and not two, with a relaxation of 0.5, and DFSPH starts from means over
the pressures of 15 steps, at 1 % with a relaxation of 0.42: each then leaves less than theirs, in the mean and at most.
SPlisHSPlasH's DFSPH runs with its own limit on the divergence, 0.1 %, at every limit on the density: with 0.01 % it stays too
thin. WCSPH has a stiffness of 450 kPa here and 294 kPa there: with 294 kPa ours leaves a mean error of 0.121 % to their 0.100,
as its water is a quarter heavier; with 450 kPa theirs did not end in thirteen minutes.

The Python package pysplishsplash is installed into target/peers-venv. Its wheel needs the system's libGL, and the
loader must take the system's libGLX and libGLdispatch before the wheel's own. Where it does not start, its rows say so.
"""

import argparse
import ctypes.util
import json
import os
import pathlib
import statistics
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
VENV = ROOT / "target/peers-venv"
HERE = pathlib.Path(__file__).resolve().parent

# The scene of assets/scenes/corner_dam_break_130k.ron in SPlisHSPlasH's terms: it leaves out the last layer of a block.
SCENE = {"spacing": 0.02, "tank": [[0, 0, 0], [3.06, 2.04, 2.04]], "block": [[0, 0, 0], [1.02, 1.06, 1.02]], "viscosity": 0.01}

# One system after the other: there is nothing beside ours. The tank is closed, so a dense structure covers it: the fastest of
# ours in motion (assets/studies/table_2.ron). It sorts its entries anyway, so rows may lie as they are for longer: 100 steps
# and not 25 save 2 to 4 % here, where the search of compact hashing takes 8 % more.
FASTEST = ["executor=SingleThreaded", "index.structure=IndexSort", "reorder_interval=100"]

# Name; what overfall runs; what SPlisHSPlasH runs; salva's tolerance.
CASES = [
    (
        "PCISPH, mean error 1 %, dt 1 ms",
        ["pressure=Pcisph(criterion:Mean,max_density_error:0.01,warm_start:0.5)"],
        {"method": "pcisph", "dt": 0.001, "tolerance": 0.01, "min_iterations": 3},
        None,
    ),
    (
        "PCISPH, largest error 1 %, dt 1 ms",
        ["pressure=Pcisph(criterion:Largest,max_density_error:0.01,warm_start:0.5)"],
        {"method": "pcisph", "dt": 0.001, "tolerance": 0.01, "min_iterations": 3},
        None,
    ),
    (
        "IISPH, mean error 1 %, dt 1 ms",
        ["pressure=Iisph(criterion:Mean,max_density_error:0.01,min_iterations:3,relaxation:0.5)"],
        {"method": "iisph", "dt": 0.001, "tolerance": 0.01, "min_iterations": 2},
        None,
    ),
    (
        "DFSPH, mean error 1 %, dt 1 ms",
        ["pressure=Dfsph(criterion:Mean,max_density_error:0.01,relaxation:0.42,warm_start:1.0,warm_start_steps:15)"],
        {"method": "dfsph", "dt": 0.001, "tolerance": 0.01, "min_iterations": 2},
        0.01,
    ),
    (
        "DFSPH, mean error 0.01 %, dt 1 ms",
        ["pressure=Dfsph(criterion:Mean,max_density_error:0.0001,warm_start:1.0,warm_start_steps:15)"],
        {"method": "dfsph", "dt": 0.001, "tolerance": 0.0001, "min_iterations": 2},
        None,
    ),
    (
        "WCSPH (SESPH, Tait), dt 0.5 ms",
        ["pressure=Sesph(equation:Tait(stiffness:450000))", "time_step=Fixed(0.0005)"],
        {"method": "wcsph", "dt": 0.0005, "tolerance": 0.01, "min_iterations": 2, "stiffness_pa": 294300.0},
        None,
    ),
]


def say(text):
    print(text, file=sys.stderr, flush=True)


def answer(command, environment=None):
    """The last line of a program's output as JSON; None and a word of explanation if it fails."""
    run = subprocess.run(command, cwd=ROOT, env={**os.environ, **(environment or {})}, capture_output=True, text=True)
    lines = run.stdout.strip().splitlines()
    if run.returncode != 0 or not lines:
        tail = (run.stderr.strip().splitlines() or ["no output"])[-1]
        say(f"    failed ({run.returncode}): {tail}")
        return None
    return json.loads(lines[-1])


def bench_program():
    """Builds the bench and gives its path."""
    say("building the bench")
    package = ["--manifest-path", HERE / "Cargo.toml", "--target-dir", ROOT / "target/peers"]
    command = ["cargo", "bench", "--no-run", *package, "--message-format=json"]
    build = subprocess.run(command, cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True)
    messages = (json.loads(line) for line in build.stdout.splitlines() if line.startswith("{"))
    return next(m["executable"] for m in messages if m.get("executable") and m["target"]["name"] == "peers")


def splishsplash_environment(threads):
    """Installs the package if it is missing, and gives the environment it starts in."""
    python = VENV / "bin/python"
    if not python.exists():
        say(f"installing pysplishsplash into {VENV.relative_to(ROOT)}")
        subprocess.run([sys.executable, "-m", "venv", VENV], check=True)
        subprocess.run([VENV / "bin/pip", "install", "--quiet", "pysplishsplash", "numpy"], check=True)
    libraries = [name for name in ("GLX", "GLdispatch") if ctypes.util.find_library(name)]
    preload = ":".join(ctypes.util.find_library(name) for name in libraries)
    return str(python), {"LD_PRELOAD": preload, "OMP_NUM_THREADS": str(threads)}


def summary(rounds):
    """The rounds of one program as one result."""
    rounds = [r for r in rounds if r]
    if not rounds:
        return None
    result = dict(rounds[-1])
    result["ms_per_step"] = statistics.median(r["ms_per_step"] for r in rounds)
    return result


def row(name, program, result, ours):
    """A line of the table."""
    if result is None:
        return f"{name:44} {program:13} did not run"
    iterations = "" if not result.get("iterations") else f"{result['iterations']:.1f}"
    ratio = "" if result is ours or ours is None else f"{result['ms_per_step'] / ours['ms_per_step']:.2f}"
    return (
        f"{name:44} {program:13} {result['ms_per_step']:8.1f} {ratio:>6} {iterations:>6} "
        f"{100 * result['mean_density_error']:8.3f} {100 * result['max_density_error']:8.2f} {result['boundary_particles']:9d}"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--start", type=float, default=0.0, help="simulated time before the first step that counts [s]")
    parser.add_argument("--duration", type=float, default=0.5, help="simulated time that counts [s]")
    parser.add_argument("--rounds", type=int, default=1)
    parser.add_argument("--threads", type=int, default=2)
    parser.add_argument("--only", action="append", help="methods whose name starts so")
    options = parser.parse_args()
    bench = bench_program()
    python, environment = splishsplash_environment(options.threads)
    print(f"{'':44} {'':13} {'ms/step':>8} {'ratio':>6} {'iter.':>6} {'mean %':>8} {'max %':>8} {'boundary':>9}")
    for name, overrides, theirs, tolerance in CASES:
        if options.only and not any(name.startswith(prefix) for prefix in options.only):
            continue
        steps, warm_up = (round(time / theirs["dt"]) for time in (options.duration, options.start))
        counts = [str(steps), str(warm_up), str(options.threads)]
        case = json.dumps({**SCENE, **theirs, "steps": steps, "warm_up": warm_up})
        programs = {
            "overfall": lambda: answer([bench, "overfall", *counts, *FASTEST, *overrides]),
            "SPlisHSPlasH": lambda: answer([python, HERE / "splishsplash.py", case], environment),
        }
        if tolerance is not None:
            programs["salva"] = lambda: answer([bench, "salva", *counts, str(tolerance)])
        results = {program: [] for program in programs}
        for round_number in range(options.rounds):
            for program, run in programs.items():
                say(f"{name}: {program}, {steps} steps, round {round_number + 1} of {options.rounds}")
                results[program].append(run())
        ours = summary(results["overfall"])
        for program in programs:
            result = ours if program == "overfall" else summary(results[program])
            print(row(name if program == "overfall" else "", program, result, ours), flush=True)


main()
