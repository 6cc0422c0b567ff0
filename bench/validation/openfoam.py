"""Runs OpenFOAM's viewFactorsGen and viewpeel on the room of tests/files/openfoam_room, 1 x 2 x 3."""
import os
import re
import resource
import shutil
import subprocess

import forms
from run_cases import ROOT, row_of

WALLS = ["west", "east", "south", "north", "floor", "ceiling"]  # the order of the case's patches
PAIRS = {("west", "east"): forms.equal_rectangles(2, 3, 1), ("south", "north"): forms.equal_rectangles(1, 3, 2),
         ("floor", "ceiling"): forms.equal_rectangles(1, 2, 3), ("west", "south"): forms.perpendicular_rectangles(1, 3, 2),
         ("west", "floor"): forms.perpendicular_rectangles(1, 2, 3), ("south", "floor"): forms.perpendicular_rectangles(2, 1, 3)}  # fmt: skip


def lists_of(file):
    """Reads the lists of numbers in an OpenFOAM file that is a list of lists."""
    text = re.sub(r"/\*.*?\*/|//[^\n]*|FoamFile\s*\{.*?\}", "", file.read_text(), flags=re.S)
    lists = []
    for count, repeated, listed in re.findall(r"(\d+)\s*(?:\{([^{}]*)\}|\(([^()]*)\))", text):
        lists.append([float(repeated)] * int(count) if repeated else [float(x) for x in listed.split()])
    return lists


def run(folder, cells, program):
    """Returns six rows, one for each pair of walls: the pair, its closed form, the errors of viewpeel and of
    viewFactorsGen, and viewFactorsGen's number of coarse faces and CPU seconds."""
    shutil.copytree(ROOT / "tests/files/openfoam_room", folder)
    for name, old, new in (("system/blockMeshDict", r"\(2 2 2\)", f"({cells} {cells} {cells})"), ("constant/viewFactorsDict", r"nFacesInCoarsestLevel 2", "nFacesInCoarsestLevel 100000")):
        text, count = re.subn(old, new, (folder / name).read_text())
        assert count > 0, name
        (folder / name).write_text(text)
    environment = os.environ | {"WM_PROJECT_DIR": "/usr/share/openfoam"}
    for tool in ("blockMesh", "faceAgglomerate", "viewFactorsGen"):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([tool], cwd=folder, env=environment, check=True, capture_output=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    factors, seen = lists_of(folder / "constant/F"), lists_of(folder / "constant/globalFaceFaces")
    assert len(factors) == len(seen) and len(factors) % len(WALLS) == 0, "walls of as many coarse faces each"
    per_wall = len(factors) // len(WALLS)
    wall = lambda row: WALLS[int(row) // per_wall]
    output = folder / "walls.csv"
    # The scene is the room as an .obj: an OpenFOAM case would be read with its coarse faces as surfaces, not the walls.
    scene = folder / "room.obj"
    corners = [(x, y, z) for z in (0, 3) for y in (0, 2) for x in (0, 1)]
    faces = {"west": (1, 3, 7, 5), "east": (2, 6, 8, 4), "south": (1, 5, 6, 2), "north": (3, 4, 8, 7), "floor": (1, 2, 4, 3), "ceiling": (5, 7, 8, 6)}
    scene.write_text("".join(f"v {x} {y} {z}\n" for x, y, z in corners) + "".join(f"o {name}\nf {' '.join(map(str, face))}\n" for name, face in faces.items()))
    subprocess.run([program, "compute", scene, "--by", "surface", "--quiet", "-o", output], check=True)
    rows = []
    for (a, b), value in PAIRS.items():
        of_wall = [row for row in range(len(factors)) if wall(row) == a]
        flow = sum(f for row in of_wall for f, other in zip(factors[row], seen[row]) if wall(other) == b)
        ours = float(row_of(output, a, b)["form_factor"])
        rows.append({"pair": f"{a} to {b}", "closed form": f"{value:.7g}", "viewpeel's error": f"{ours - value:.1e}",
                     "coarse faces": len(factors), "viewFactorsGen's error": f"{flow / per_wall - value:.1e}",
                     "its CPU s": f"{after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime:.2f}"})  # fmt: skip
    return rows
