"""Runs View3D on a configuration of flat shapes, for comparison."""
import pathlib
import resource
import subprocess

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent


def run_view3d(program, case, folder):
    """Returns (form factor, CPU s) at View3D's default settings."""
    names = write_scene(case, folder / "case.vs3")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([program, "case.vs3", "case.txt"], cwd=folder, check=True, capture_output=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    rows = [[float(word) for word in line.split()] for line in (folder / "case.txt").read_text().splitlines()[1:]]
    areas, factors = rows[0], rows[1:]
    is_of = lambda name, surface: name == surface or name.startswith(surface + ".")
    emitting = [k for k, name in enumerate(names) if is_of(name, case.source_shape)]
    receiving = [k for k, name in enumerate(names) if is_of(name, case.target)]
    flow = sum(areas[i] * factors[i][j] for i in emitting for j in receiving)
    return flow / sum(areas[i] for i in emitting), after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def write_scene(case, file):
    """Writes the scene and returns the names of View3D's rows."""
    if case.file:
        text = (ROOT / case.file).read_text()
        file.write_text(text)
        lines = [line.split() for line in text.split("\nE")[0].splitlines()]
        # Field 7 of a surface is the surface into which View3D combines it; only surfaces with 0 there have a row.
        return [words[9] for words in lines if words and words[0] == "S" and words[7] == "0"]
    names = list(case.shapes)
    with open(file, "w") as out:
        out.write(f"T {case.name}\nC encl=0 emit=0 out=0\nF 3\n")
        for k, name in enumerate(names):
            for c, corner in enumerate(case.shapes[name].corners()):
                out.write(f"V {4 * k + c + 1} " + " ".join(f"{float(x):.15g}" for x in corner) + "\n")
        for k, name in enumerate(names):
            out.write(f"S {k + 1} " + " ".join(str(4 * k + c) for c in (1, 2, 3, 4)) + f" 0 0 0.9 {name}\n")
        out.write("End\n")
    return names
