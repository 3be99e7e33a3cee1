"""Reads what a run wrote with readers that are not ours, and checks that they agree with its summary.

    python3 -m venv venv && venv/bin/pip install meshio vtk pysplashsurf
    venv/bin/python tests/read_frames.py out/dam_break      # a run's folder
    venv/bin/python tests/read_frames.py frames.pvd frame_000000.vtu frame_000000.ply

meshio reads every frame; the vtk library, on which ParaView stands, does too if it is installed. splashsurf, if
installed, makes a surface of the last frame of a run, and so shows that it reads it. Exit status 1 and a message on the
first mismatch.
"""

import csv
import json
import sys
import tempfile
import xml.etree.ElementTree as ET
from pathlib import Path

import meshio
import numpy as np

try:
    import vtk
    from vtk.util.numpy_support import vtk_to_numpy
except ImportError:
    vtk = None

try:
    import pysplashsurf
except ImportError:
    pysplashsurf = None

# Name and number of components; SI units: m/s, kg/m3, Pa, none.
FIELDS = {"velocity": 3, "density": 1, "pressure": 1, "id": 1}


def require(condition, message):
    if not condition:
        sys.exit(f"read_frames: {message}")


def check_columns(path, points, columns):
    """Shapes, finite values, distinct ids; returns the number of particles."""
    require(points.ndim == 2 and points.shape[1] == 3, f"{path}: points are {points.shape}, not (n, 3)")
    require(np.isfinite(points).all(), f"{path}: a position is not finite")
    for name, components in FIELDS.items():
        require(name in columns, f"{path}: no field {name!r}, only {sorted(columns)}")
        values = columns[name]
        shape = (len(points), components) if components > 1 else (len(points),)
        require(values.shape == shape, f"{path}: {name} is {values.shape}, not {shape}")
        require(np.isfinite(values).all(), f"{path}: {name} is not finite somewhere")
    require(np.issubdtype(columns["id"].dtype, np.integer), f"{path}: id is {columns['id'].dtype}")
    require(len(np.unique(columns["id"])) == len(points), f"{path}: an id occurs twice")
    return len(points)


def read_vtu(path):
    """Returns number of particles and time [s] as meshio sees them."""
    mesh = meshio.read(path)
    count = check_columns(path, mesh.points, mesh.point_data)
    vertices = sum(len(block.data) for block in mesh.cells if block.type == "vertex")
    require(vertices == count, f"{path}: {vertices} vertex cells, {count} points")
    time = float(np.ravel(mesh.field_data["TimeValue"])[0])
    if vtk is not None:
        compare_with_vtk(path, mesh, time, FIELDS, count)
    return count, time


def read_walls(path):
    """Returns the number of boundary particles and the time [s]."""
    mesh = meshio.read(path)
    normals = mesh.point_data["normal"]
    require(np.allclose(np.linalg.norm(normals, axis=1), 1, atol=1e-4), f"{path}: a normal has not length 1")
    require((mesh.point_data["volume"] >= 0).all(), f"{path}: a volume is negative")
    time = float(np.ravel(mesh.field_data["TimeValue"])[0])
    if vtk is not None:
        compare_with_vtk(path, mesh, time, ["normal", "volume"], len(mesh.points))
    return len(mesh.points), time


def read_surface(path):
    """Returns the number of vertices of a surface of triangles, and the time [s]."""
    mesh = meshio.read(path)
    triangles = mesh.cells_dict.get("triangle", np.zeros((0, 3), int))
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    pairs = set(map(tuple, edges.tolist()))
    require(len(pairs) == len(edges), f"{path}: an edge has two triangles on one side")
    require(all((b, a) in pairs for a, b in pairs), f"{path}: the surface is open")
    require(np.isfinite(mesh.point_data["velocity"]).all(), f"{path}: a velocity is not finite")
    time = float(np.ravel(mesh.field_data["TimeValue"])[0])
    if vtk is not None:
        compare_with_vtk(path, mesh, time, ["velocity", "normal"], len(triangles))
    return len(mesh.points), time


def make_surface(path, count):
    """splashsurf makes a surface of a frame with its own reader."""
    points = meshio.read(path).points
    # About half of the spacing: what matters here is what is read.
    radius = 0.25 * np.ptp(points, axis=0).max() / max(count, 1) ** (1 / 3)
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "surface.vtk"
        arguments = ["splashsurf", "reconstruct", str(path), "-o", str(made), "-q", "-a", "velocity"]
        arguments += [f"-r={radius}", "-l=2.0", "-c=1.0"]
        pysplashsurf.run_splashsurf(arguments)
        require(made.is_file(), f"{path}: splashsurf made no surface of it")
        surface = meshio.read(made)
    require(len(surface.points) > 0, f"{path}: splashsurf read no particle")
    require("velocity" in surface.point_data, f"{path}: splashsurf read no velocity")
    low, high = surface.points.min(axis=0), surface.points.max(axis=0)
    around = (low <= points.min(axis=0) + radius).all() and (high >= points.max(axis=0) - radius).all()
    require(around, f"{path}: splashsurf read other points")


def compare_with_vtk(path, mesh, time, fields, cells):
    reader = vtk.vtkXMLUnstructuredGridReader()
    reader.SetFileName(str(path))
    reader.Update()
    require(reader.GetErrorCode() == 0, f"{path}: vtk error {reader.GetErrorCode()}")
    grid = reader.GetOutput()
    require(grid.GetNumberOfPoints() == len(mesh.points), f"{path}: vtk sees {grid.GetNumberOfPoints()} points")
    require(grid.GetNumberOfCells() == cells, f"{path}: vtk sees {grid.GetNumberOfCells()} cells")
    vtk_time = grid.GetFieldData().GetArray("TimeValue")
    require(vtk_time is not None and vtk_time.GetValue(0) == time, f"{path}: vtk sees another time")
    if len(mesh.points) == 0:
        return
    require(np.array_equal(vtk_to_numpy(grid.GetPoints().GetData()), mesh.points), f"{path}: vtk sees other points")
    for name in fields:
        array = grid.GetPointData().GetArray(name)
        require(array is not None, f"{path}: vtk sees no {name!r}")
        require(np.array_equal(vtk_to_numpy(array), mesh.point_data[name]), f"{path}: vtk sees another {name}")


def read_ply(path):
    """Returns the number of particles as meshio sees them."""
    mesh = meshio.read(path)
    columns = dict(mesh.point_data)
    require({"vx", "vy", "vz"} <= columns.keys(), f"{path}: no velocity")
    columns["velocity"] = np.column_stack([columns.pop(name) for name in ("vx", "vy", "vz")])
    return check_columns(path, mesh.points, columns)


def read_series(path, read=read_vtu):
    """Reads every frame of a series; returns the particle numbers of its frames."""
    counts, last = [], -np.inf
    for entry in ET.parse(path).getroot().iter("DataSet"):
        frame = path.parent / entry.attrib["file"]
        require(frame.is_file(), f"{path}: {frame} is missing")
        count, time = read(frame)
        listed = float(entry.attrib["timestep"])
        require(listed == time, f"{path}: {frame.name} at {listed} s, the file says {time} s")
        require(time > last, f"{path}: times do not increase at {time} s")
        last = time
        counts.append(count)
    require(counts, f"{path}: no frames")
    return counts


def read_run(folder):
    """Compares a run's frames and history with its summary."""
    summary = json.loads((folder / "summary.json").read_text())
    read = 0
    # Files beside the frames, with the reader of each.
    beside = {"boundary.pvd": read_walls, "surface.pvd": read_surface}
    for name, read_one in beside.items():
        for series in sorted(folder.rglob(name)):
            read_series(series, read_one)
    for walls in sorted(folder.rglob("boundary.vtu")):
        count = read_walls(walls)[0]
        require(
            count == summary["boundary_particles"],
            f"{walls}: {count} boundary particles, the summary says {summary['boundary_particles']}",
        )
    for series in sorted(folder.rglob("*.pvd")):
        if series.name in beside:
            continue
        counts = read_series(series)
        require(
            counts[-1] == summary["particles"],
            f"{series}: {counts[-1]} particles in the last frame, the summary says {summary['particles']}",
        )
        require(len(counts) == summary["frames"], f"{series}: {len(counts)} frames, the summary says {summary['frames']}")
        read += len(counts)
        # Of no particles there is no surface.
        if pysplashsurf is not None and counts[-1] > 0:
            last = list(ET.parse(series).getroot().iter("DataSet"))[-1]
            make_surface(series.parent / last.attrib["file"], counts[-1])
    plies = sorted(folder.rglob("frames/*.ply"))
    for ply in plies:
        count = read_ply(ply)
    if plies:
        require(count == summary["particles"], f"{plies[-1]}: {count} particles, not {summary['particles']}")
    require(read + len(plies) > 0, f"{folder}: no frames")

    with open(folder / "history.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    require(len(rows) == summary["steps"], f"history.csv has {len(rows)} rows, the summary says {summary['steps']} steps")
    require(all(None not in row and None not in row.values() for row in rows), "history.csv: a row is not whole")
    times = [float(row["t_s"]) for row in rows]
    require(all(a < b for a, b in zip(times, times[1:])), "history.csv: times do not increase")
    return f"{read} vtu and {len(plies)} ply frames, {len(rows)} steps"


def main(arguments):
    require(arguments, "give a run's folder, or .pvd, .vtu, .ply files")
    for argument in arguments:
        path = Path(argument)
        if path.is_dir():
            found = read_run(path)
        elif path.suffix == ".pvd":
            found = f"{len(read_series(path))} frames"
        elif path.suffix == ".ply":
            found = f"{read_ply(path)} particles"
        else:
            found = f"{read_vtu(path)[0]} particles"
        # splashsurf reads what a run wrote, not single files.
        others = [("vtk", vtk), ("splashsurf", pysplashsurf and path.is_dir())]
        others = [name for name, reads in others if reads]
        print(f"{path}: {found}; read by {' and '.join(['meshio', *others])}")


if __name__ == "__main__":
    main(sys.argv[1:])
