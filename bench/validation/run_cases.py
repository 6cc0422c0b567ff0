"""Runs viewpeel on a configuration, and judges its errors."""
import csv
import json
import math
import pathlib
import resource
import subprocess
from dataclasses import dataclass

from scipy.stats import t as student

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
FALSE_ALARM = 1e-6  # probability that one right configuration is found wrong
ROUNDING = 1e-9  # allowed for the rounding of corners written with 17 digits, and of closed forms


@dataclass
class Answer:
    value: float
    stated: float  # standard error, or half the interval
    allowed: float  # largest error
    lower: float
    upper: float
    cpu_s: float


def write_obj(shapes, names, pieces, file):
    """Writes the shapes as a scene.    In: names: the surface of each shape"""
    corners = 0
    with open(file, "w") as out:
        for shape in sorted(shapes, key=names.get):
            out.write(f"o {names[shape]}\n")
            for face in shapes[shape].mesh(pieces):
                for corner in face:
                    out.write("v " + " ".join(f"{float(x):.17g}" for x in corner) + "\n")
                out.write("f " + " ".join(str(corners + k + 1) for k in range(len(face))) + "\n")
                corners += len(face)


def row_of(file, source, target):
    with open(file, newline="") as lines:
        for row in csv.DictReader(lines):
            if row["from"] == source and row["to"] == target:
                return row
    return None


def name_of(shape, case):
    """Returns a shape's surface: the word before the dot, unless the shape is the case's source or target."""
    return shape.replace(".", "_") if shape in (case.source_shape, case.target) else shape.split(".")[0]


class Program:
    """Runs viewpeel with a goal such as ["--tolerance", "1e-3"]. Configurations with the same shapes share a run."""

    def __init__(self, file, goal, folder):
        self.file, self.goal, self.folder = file, goal, folder
        self.done = {}

    def run(self, case, pieces):
        names = {shape: name_of(shape, case) for shape in case.shapes}
        key = case.file or (id(case.shapes), pieces, tuple(names.values()))
        if key in self.done:
            return self.done[key], 0.0
        scene, output = self.folder / "case.obj", self.folder / f"{len(self.done)}.csv"
        if case.file:
            scene = ROOT / case.file
        else:
            write_obj(case.shapes, names, pieces, scene)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        command = [self.file, "compute", scene, "--by", "surface", "--json", "-o", output, "-j", "2", *self.goal]
        run = subprocess.run(command, capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        if run.returncode != 0:
            raise SystemExit(f"bench/validate: {case.family}, {case.name}: the program ended with {run.returncode}: {run.stderr.strip()}")
        self.done[key] = output, json.loads(run.stdout)["replicates"]
        return self.done[key], after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    def compute(self, case, pieces):
        (output, replicates), cpu_s = self.run(case, pieces)
        row = row_of(output, name_of(case.source_shape, case), name_of(case.target, case))
        if row is None:
            raise SystemExit(f"bench/validate: {case.family}, {case.name}: the program has no such form factor")
        value = float(row["form_factor"])
        if row.get("lower"):
            lower, upper = float(row["lower"]), float(row["upper"])
            return Answer(value, (upper - lower) / 2, max(upper - value, value - lower), lower, upper, cpu_s)
        stated = float(row["standard_error"])
        allowed = student.ppf(1 - FALSE_ALARM / 2, replicates - 1) * stated
        return Answer(value, stated, allowed, value - allowed, value + allowed, cpu_s)


@dataclass
class Verdict:
    case: object
    answers: list  # of each level, the finest last
    value: float  # the finest answer, or the limit of finer and finer pieces
    stated: float
    error: float
    allowed: float
    order: float  # of convergence; nan for flat shapes and where sampling hides it
    cpu_s: float

    @property
    def holds(self):
        return abs(self.error) <= self.allowed


def judge_flat(case, answer):
    error = answer.value - case.value
    # The truth has to lie in the interval, or within the standard errors that are allowed.
    allowed = (answer.upper - answer.value if error < 0 else answer.value - answer.lower) + ROUNDING
    return Verdict(case, [answer], answer.value, answer.stated, error, allowed, math.nan, answer.cpu_s)


def judge_round(case, answers):
    """The error of n pieces is a n^-2 + b n^-4 + ..., for shapes are smooth and corners lie on them. Richardson's step
    (4 F(2n) - F(n)) / 3 leaves 1/4 of -b n^-4. The step before leaves 16 times as much, so that the two steps differ by 15
    times the error of the finer one. Their difference is the bound of the pieces' error. Errors stated come on top."""
    ratio = [b / a for a, b in zip(case.levels, case.levels[1:])]
    steps = [fine.value + (fine.value - coarse.value) / (r * r - 1) for coarse, fine, r in zip(answers, answers[1:], ratio)]
    weight = 1 / (ratio[-1] ** 2 - 1)
    from_pieces = abs(steps[-1] - steps[-2])
    from_samples = (1 + weight) * answers[-1].allowed + weight * answers[-2].allowed
    value = steps[-1]
    first, second = answers[-2].value - answers[-3].value, answers[-1].value - answers[-2].value
    noise = sum(answer.stated for answer in answers)
    seen = abs(second) > 10 * noise and first * second > 0 and ratio[0] == ratio[1]
    order = math.log(first / second, ratio[-1]) if seen else math.nan
    return Verdict(case, answers, value, (1 + weight) * answers[-1].stated, value - case.value,
                   from_pieces + from_samples + ROUNDING, order, sum(a.cpu_s for a in answers))  # fmt: skip


def run_case(program, case):
    answers = [program.compute(case, pieces) for pieces in case.levels or (1,)]
    return judge_round(case, answers) if case.levels else judge_flat(case, answers[0])
