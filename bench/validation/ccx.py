"""Runs CalculiX's ccx and viewpeel on one deck of a room, 1 x 2 x 3, whose walls are slabs of bricks."""
import os
import resource
import subprocess

import numpy as np
from openfoam import PAIRS, WALLS

SIDES = (1, 2, 3)
THICKNESS = 0.1
# By wall: the inner face's corner and its two edges, whose product points into the room.
FACES = {"west": ((0, 0, 0), (0, 2, 0), (0, 0, 3)), "east": ((1, 0, 0), (0, 0, 3), (0, 2, 0)),
         "south": ((0, 0, 0), (0, 0, 3), (1, 0, 0)), "north": ((0, 2, 0), (1, 0, 0), (0, 0, 3)),
         "floor": ((0, 0, 0), (1, 0, 0), (0, 2, 0)), "ceiling": ((0, 0, 3), (0, 2, 0), (1, 0, 0))}  # fmt: skip


def deck(cells):
    """Returns the deck. Each wall has cells x cells bricks, in the order of WALLS, and face R2 of a brick is its inner face."""
    nodes, elements = [], []
    for wall in WALLS:
        origin, u, v = (np.array(of, float) for of in FACES[wall])
        outwards = -THICKNESS * np.cross(u, v) / np.linalg.norm(np.cross(u, v))
        for i in range(cells):
            for j in range(cells):
                first = len(nodes) + 1
                for depth in (outwards, 0):
                    nodes += [origin + ((i + a) * u + (j + b) * v) / cells + depth for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
                elements.append(range(first, first + 8))
    lines = ["*NODE, NSET=ALL"] + [f"{k + 1}, " + ", ".join(f"{x:.17g}" for x in node) for k, node in enumerate(nodes)]
    lines += ["*ELEMENT, TYPE=C3D8, ELSET=EALL"] + [f"{k + 1}, " + ", ".join(map(str, element)) for k, element in enumerate(elements)]
    lines += ["*MATERIAL, NAME=M", "*CONDUCTIVITY", "1.", "*SOLID SECTION, ELSET=EALL, MATERIAL=M",
              "*PHYSICAL CONSTANTS, ABSOLUTE ZERO=0., STEFAN BOLTZMANN=5.669E-8", "*INITIAL CONDITIONS, TYPE=TEMPERATURE", "ALL, 300.",
              "*STEP", "*HEAT TRANSFER, STEADY STATE", "1., 1.", "*VIEWFACTOR, WRITE", "*RADIATE"]  # fmt: skip
    lines += [f"{k + 1}, R2CR, 300., 1." for k in range(len(elements))]
    return "\n".join(lines + ["*END STEP"]) + "\n"


def read_vwf(file, count):
    """Returns F, count x count. Records: version; F_ii; entries below the diagonal by columns, then their transposes; the
    rest to the environment (docs/formats.md)."""
    raw, at, records = file.read_bytes(), 0, []
    while at < len(raw):
        size = int.from_bytes(raw[at : at + 4], "little")
        records.append(raw[at + 4 : at + 4 + size])
        at += size + 8
    diagonal, entries = (np.frombuffer(record, "<f8") for record in records[1:3])
    columns, rows = np.triu_indices(count, 1)
    factors = np.diag(diagonal)
    factors[rows, columns], factors[columns, rows] = entries[: len(rows)], entries[len(rows) :]
    return factors


def between_walls(factors, cells):
    """Returns F between walls, 6 x 6: cells of a wall have one area."""
    share = np.kron(np.eye(len(WALLS)), np.ones((1, cells * cells)))
    return share @ factors @ share.T / (cells * cells)


def cpu_seconds(command, folder):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=folder, env=os.environ | {"OMP_NUM_THREADS": "1"}, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def run(folder, cells, program):
    """Returns six rows, one for each pair of walls: the pair, its closed form, the errors of viewpeel and of ccx, and
    ccx's number of faces and CPU seconds."""
    folder.mkdir()
    (folder / "room.inp").write_text(deck(cells))
    time_s = cpu_seconds(["ccx", "room"], folder)
    count = len(WALLS) * cells * cells
    theirs = between_walls(read_vwf(folder / "room.vwf", count), cells)
    cpu_seconds([program, "compute", "room.inp", "--tolerance", "1e-3", "-o", "ours.vwf"], folder)
    ours = between_walls(read_vwf(folder / "ours.vwf", count), cells)
    rows = []
    for (a, b), form in PAIRS.items():
        i, j = WALLS.index(a), WALLS.index(b)
        rows.append({"pair": f"{a} to {b}", "closed form": f"{form:.7g}", "viewpeel's error": f"{ours[i, j] - form:.1e}", "faces": count,
                     "ccx's error": f"{theirs[i, j] - form:.1e}", "its CPU s": f"{time_s:.2f}"})  # fmt: skip
    return rows
