"""One run of SPlisHSPlasH on the corner dam break, in a process of its own; the result as a line of JSON.

Started by compare.py, which says how. Densities are those that the program itself holds after the last step: of the
state before that step moved it, after all earlier steps.
"""

import json
import os
import pathlib
import sys
import tempfile
import time

import pysplishsplash
import numpy

METHODS = {"wcsph": 0, "pcisph": 1, "iisph": 3, "dfsph": 4}
INVERTED_BOX = """v -0.5 -0.5 -0.5
v 0.5 -0.5 -0.5
v 0.5 0.5 -0.5
v -0.5 0.5 -0.5
v -0.5 -0.5 0.5
v 0.5 -0.5 0.5
v 0.5 0.5 0.5
v -0.5 0.5 0.5
f 1 2 3
f 1 3 4
f 5 7 6
f 5 8 7
f 1 6 2
f 1 5 6
f 4 3 7
f 4 7 8
f 1 4 8
f 1 8 5
f 2 6 7
f 2 7 3
"""


def scene(case, mesh):
    """The scene file: lengths in m, times in s, tolerances in per cent."""
    radius = case["spacing"] / 2
    lower, upper = case["tank"]
    method = {
        "minIterations": case["min_iterations"],
        "maxIterations": 1000,
        "maxError": 100 * case["tolerance"],
        "enableDivergenceSolver": True,
        # The program's default; see compare.py.
        "maxErrorV": 0.1,
        "stiffness": case.get("stiffness_pa", 294300.0),
        "exponent": 7,
    }
    return {
        "Configuration": {
            "particleRadius": radius,
            "simulationMethod": METHODS[case["method"]],
            "timeStepSize": case["dt"],
            "cflMethod": 0,
            "boundaryHandlingMethod": 0,
            "gravitation": [0, -9.81, 0],
            "stopAt": (case["warm_up"] + case["steps"] - 0.5) * case["dt"],
            **{name: method for name in ("WCSPH", "PCISPH", "IISPH", "DFSPH")},
        },
        "Materials": [
            {
                "id": "Fluid",
                "density0": 1000,
                "viscosityMethod": 1,
                "Viscosity": {"viscosity": case["viscosity"], "viscosityBoundary": 0},
                "viscosity": case["viscosity"],
                "viscosityBoundary": 0,
                "surfaceTensionMethod": 0,
            }
        ],
        "RigidBodies": [
            {
                "geometryFile": str(mesh),
                "translation": [(a + b) / 2 for a, b in zip(lower, upper)],
                "rotationAxis": [1, 0, 0],
                "rotationAngle": 0,
                "scale": [b - a for a, b in zip(lower, upper)],
                "isDynamic": False,
                "isWall": True,
                "mapInvert": True,
                "mapThickness": 0,
            }
        ],
        "FluidBlocks": [
            {"denseMode": 0, "start": case["block"][0], "end": case["block"][1], "translation": [0, 0, 0], "scale": [1, 1, 1]}
        ],
    }


def main():
    case = json.loads(sys.argv[1])
    folder = pathlib.Path(tempfile.mkdtemp())
    (folder / "box.obj").write_text(INVERTED_BOX)
    file = folder / "scene.json"
    file.write_text(json.dumps(scene(case, folder / "box.obj")))
    # The program prints to the standard output as it likes: that goes to the error output.
    answer = os.dup(1)
    os.dup2(2, 1)
    base = pysplishsplash.Exec.SimulatorBase()
    base.init(sceneFile=str(file), useGui=False, outputDir=str(folder), initialPause=False)
    base.initSimulation()
    simulation = pysplishsplash.Simulation.getCurrent()
    fluid = simulation.getFluidModel(0)
    step = simulation.getTimeStep()
    iterations = next((k for k in range(step.numParameters()) if step.getName(k) == "iterations"), None)
    times, counts, means, largest = [], [], [], []
    clock = {"step": 0, "start": time.perf_counter()}

    def after_step():
        elapsed = time.perf_counter() - clock["start"]
        if clock["step"] >= case["warm_up"]:
            times.append(1e3 * elapsed)
            if iterations is not None:
                counts.append(step.getValueInt(iterations))
            density = numpy.array(fluid.getFieldBuffer("density"), copy=True).ravel()
            compression = numpy.maximum(density / 1000 - 1, 0)
            means.append(float(compression.mean()))
            largest.append(float(compression.max()))
        clock["step"] += 1
        clock["start"] = time.perf_counter()

    base.setTimeStepCB(after_step)
    base.runSimulation()
    result = {
        "particles": fluid.numActiveParticles(),
        "boundary_particles": sum(
            simulation.getBoundaryModel(k).numberOfParticles() for k in range(simulation.numberOfBoundaryModels())
        ),
        "ms_per_step": float(numpy.mean(times)),
        "iterations": float(numpy.mean(counts)) if counts else None,
        "mean_density_error": float(numpy.mean(means)),
        "max_density_error": float(numpy.max(largest)),
    }
    os.write(answer, (json.dumps(result) + "\n").encode())
    # The program's own destructors crash at exit in some versions.
    os._exit(0)


main()
