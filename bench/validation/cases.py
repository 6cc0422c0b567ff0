"""These are the configurations of docs/validation.md: shapes, source and target, and the closed form."""
import math
from dataclasses import dataclass

import forms
from shapes import Cone, Disc, Parallelogram, Sphere, box


@dataclass
class Case:
    family: str
    name: str
    source: str
    shapes: dict
    source_shape: str  # from
    target: str  # to
    value: float
    levels: tuple = ()  # pieces around an axis; none for flat shapes, which need no pieces
    file: str = ""  # an existing scene that is computed instead; the shapes are then two of its surfaces


def rectangle(x, y, z, up):
    (a, b), (c, d) = x, y
    return Parallelogram((a, c, z), (b - a, 0, 0), (0, d - c, 0)) if up > 0 else Parallelogram((a, c, z), (0, d - c, 0), (b - a, 0, 0))


def plates():
    for a, b, c in ((1, 1, 1), (2, 1, 1), (10, 10, 1), (1, 1, 10), (20, 0.5, 1)):
        shapes = {"low": rectangle((0, a), (0, b), 0, 1), "high": rectangle((0, a), (0, b), c, -1)}
        yield Case("plates", f"opposite rectangles {a} x {b} at {c}", "C-11", shapes, "low", "high", forms.equal_rectangles(a, b, c))
    for x, y, xi, eta, z in (((0, 1), (0, 1), (1, 2), (0, 1), 1), ((0, 1), (0, 1), (2, 4), (3, 4), 1), ((0, 3), (0, 2), (1, 2), (0.5, 1), 0.5)):
        shapes = {"low": rectangle(x, y, 0, 1), "high": rectangle(xi, eta, z, -1)}
        name = f"parallel {x[0]}..{x[1]} x {y[0]}..{y[1]} to {xi[0]}..{xi[1]} x {eta[0]}..{eta[1]} at {z}"
        yield Case("plates", name, "C-13", shapes, "low", "high", forms.parallel_rectangles(x, y, xi, eta, z))
    for h, l, w in ((1, 1, 1), (0.5, 2, 1), (3, 1, 1), (0.1, 1, 5)):
        shapes = {"floor": rectangle((0, w), (0, l), 0, 1), "wall": Parallelogram((0, 0, 0), (0, l, 0), (0, 0, h))}
        yield Case("plates", f"common edge {l}, floor {w}, wall {h}", "C-14", shapes, "floor", "wall", forms.perpendicular_rectangles(h, l, w))
    for x, y, eta, zeta in (((1, 2), (0, 1), (0, 1), (1, 2)), ((0, 1), (0, 1), (1, 2), (0, 1)), ((0.1, 1), (0, 3), (1, 2), (0, 0.5))):
        shapes = {"floor": rectangle(x, y, 0, 1),
                  "wall": Parallelogram((0, eta[0], zeta[0]), (0, eta[1] - eta[0], 0), (0, 0, zeta[1] - zeta[0]))}  # fmt: skip
        name = f"floor {x[0]}..{x[1]} x {y[0]}..{y[1]} to wall {eta[0]}..{eta[1]} x {zeta[0]}..{zeta[1]}"
        yield Case("plates", name, "Ehlert & Smith", shapes, "floor", "wall", forms.perpendicular_apart(x, y, eta, zeta))


def wedges():
    for degrees in (0.1, 1, 10, 30, 60, 90, 120, 150, 170, 179, 179.9):
        angle = math.radians(degrees)
        shapes = {"floor": rectangle((0, 1), (0, 1), 0, 1), "wall": Parallelogram((0, 0, 0), (0, 1, 0), (math.cos(angle), 0, math.sin(angle)))}
        yield Case("wedges", f"unit squares at {degrees} degrees", "C-16", shapes, "floor", "wall", forms.wedge(1, 1, 1, angle))
    for degrees, width in ((45, 3), (135, 0.2)):
        angle = math.radians(degrees)
        shapes = {"floor": rectangle((0, 1), (0, 2), 0, 1), "wall": Parallelogram((0, 0, 0), (0, 2, 0), (width * math.cos(angle), 0, width * math.sin(angle)))}
        yield Case("wedges", f"1 x 2 and {width} x 2 at {degrees} degrees", "C-16", shapes, "floor", "wall", forms.wedge(1, width, 2, angle))


ROUND = (16, 32, 64)


def discs():
    for a, b, h in ((1, 1, 1), (1, 2, 1), (0.5, 1, 2), (1, 1, 0.2), (5, 1, 1)):
        shapes = {"low": Disc(0, a), "high": Disc(h, b, up=-1)}
        yield Case("discs", f"radius {a} to radius {b} at {h}", "C-41", shapes, "low", "high", forms.coaxial_discs(a, b, h), ROUND)
    for inner, outer, disc, h in ((0.5, 1, 1, 1), (0.8, 2, 0.5, 0.5)):
        shapes = {"ring": Disc(0, outer, inner), "disc": Disc(h, disc, up=-1)}
        yield Case("discs", f"annulus {inner}..{outer} to disc {disc} at {h}", "algebra of C-41", shapes, "ring", "disc",
                   forms.annulus_to_disc(inner, outer, disc, h), ROUND)  # fmt: skip
    for inner, outer, to_inner, to_outer, h in ((0.5, 1, 0.5, 1, 1), (0.2, 1, 1, 2, 0.5)):
        shapes = {"low": Disc(0, outer, inner), "high": Disc(h, to_outer, to_inner, up=-1)}
        yield Case("discs", f"annulus {inner}..{outer} to annulus {to_inner}..{to_outer} at {h}", "algebra of C-41", shapes, "low", "high",
                   forms.annuli(inner, outer, to_inner, to_outer, h), ROUND)  # fmt: skip


def cylinders():
    for r, h in ((1, 1), (1, 4), (2, 0.5)):
        shapes = {"base": Disc(0, r), "side": Cone((0, h), (r, r), out=-1), "lid": Disc(h, r, up=-1)}
        yield Case("cylinders", f"radius {r}, height {h}: side to itself", "Howell", shapes, "side", "side", forms.cylinder_to_itself(r, h), ROUND)
        yield Case("cylinders", f"radius {r}, height {h}: base to side", "Howell", shapes, "base", "side", forms.cylinder_base_to_side(r, h), ROUND)
    for first, second, gap in ((1, 1, 0), (0.5, 1, 0.5)):
        shapes = {"low": Cone((0, first), (1, 1), out=-1), "high": Cone((first + gap, first + gap + second), (1, 1), out=-1)}
        yield Case("cylinders", f"ring {first} to ring {second} at {gap}, radius 1", "algebra of C-41", shapes, "low", "high",
                   forms.cylinder_rings(1, first, second, gap), ROUND)  # fmt: skip
    for inner, outer, h in ((1, 2, 2), (1, 1.25, 4), (0.2, 1, 1)):
        shapes = {"inner": Cone((0, h), (inner, inner)), "outer": Cone((0, h), (outer, outer), out=-1),
                  "low": Disc(0, outer, inner), "high": Disc(h, outer, inner, up=-1)}  # fmt: skip
        arguments = (inner, outer, h)
        for name, source, a, b, form in (
            ("outer to inner", "Howell", "outer", "inner", forms.outer_to_inner_cylinder), ("outer to itself", "Howell", "outer", "outer", forms.outer_cylinder_to_itself),
            ("inner to end", "closure", "inner", "low", forms.inner_cylinder_to_end), ("outer to end", "closure", "outer", "high", forms.outer_cylinder_to_end),
            ("end to end", "closure", "low", "high", forms.end_to_end)):  # fmt: skip
            yield Case("coaxial cylinders", f"radii {inner}, {outer}, height {h}: {name}", source, shapes, a, b, form(*arguments), (8, 16, 32))


def cones():
    for r, h in ((1, 1), (1, 3)):
        slant = math.hypot(r, h)
        shapes = {"base": Disc(0, r), "side": Cone((0, h), (r, 0), out=-1)}
        yield Case("cones", f"radius {r}, height {h}: side to base", "reciprocity", shapes, "side", "base", r / slant, ROUND)
        yield Case("cones", f"radius {r}, height {h}: side to itself", "reciprocity", shapes, "side", "side", 1 - r / slant, ROUND)
    for a, b, h in ((1, 0.5, 1), (1, 3, 0.5)):
        side = math.pi * (a + b) * math.hypot(h, a - b)
        between = forms.coaxial_discs(a, b, h)
        shapes = {"base": Disc(0, a), "side": Cone((0, h), (a, b), out=-1), "lid": Disc(h, b, up=-1)}
        yield Case("cones", f"frustum {a}, {b}, height {h}: base to side", "algebra of C-41", shapes, "base", "side", 1 - between, ROUND)
        to_ends = (math.pi * a * a * (1 - between) + math.pi * (b * b - a * a * between)) / side
        yield Case("cones", f"frustum {a}, {b}, height {h}: side to itself", "algebra of C-41", shapes, "side", "side", 1 - to_ends, ROUND)


def spheres():
    BALL = (12, 24, 48)
    for disc, h in ((1, 2), (3, 1.5), (0.5, 5)):
        shapes = {"sphere": Sphere(0, 1), "disc": Disc(-h, disc)}
        yield Case("spheres", f"to disc {disc} at {h}", "solid angle", shapes, "sphere", "disc", forms.sphere_to_disc(disc, h), BALL)
    shapes = {"sphere": Sphere(0, 1), "ring": Disc(-2, 3, 1)}
    yield Case("spheres", "to annulus 1..3 at 2", "solid angle", shapes, "sphere", "ring", forms.sphere_to_disc(3, 2) - forms.sphere_to_disc(1, 2), BALL)
    for a, b, h in ((1, 1, 2), (4, 1, 1.5)):
        shapes = {"sphere": Sphere(0, 1), "plate": rectangle((0, a), (0, b), -h, 1)}
        yield Case("spheres", f"to plate {a} x {b} from its corner at {h}", "solid angle", shapes, "sphere", "plate", forms.sphere_to_corner(a, b, h), BALL)
    for inner in (0.5, 0.75):
        shapes = {"inner": Sphere(0, inner), "outer": Sphere(0, 1, out=-1)}
        yield Case("spheres", f"concentric {inner}, 1: outer to inner", "reciprocity", shapes, "outer", "inner", inner**2, (10, 20, 40))
        yield Case("spheres", f"concentric {inner}, 1: outer to itself", "reciprocity", shapes, "outer", "outer", 1 - inner**2, (10, 20, 40))
    for name, polar in (("hemisphere", math.pi / 2), ("cap of 60 degrees", math.pi / 3)):
        shapes = {"cap": Sphere(0, 1, out=-1, polar=(0, polar)), "base": Disc(math.cos(polar), math.sin(polar))}
        share = math.sin(polar) ** 2 / (2 * (1 - math.cos(polar)))
        levels = (12, 24, 48)
        yield Case("spheres", f"{name} to its base", "sphere inside", shapes, "cap", "base", share, levels)
        yield Case("spheres", f"{name} to itself", "sphere inside", shapes, "cap", "cap", 1 - share, levels)
    shapes = {"low": Sphere(0, 1, out=-1, polar=(math.pi / 2, math.pi)), "high": Sphere(0, 1, out=-1, polar=(0, math.pi / 3))}
    yield Case("spheres", "inside, half to a cap of 60 degrees", "sphere inside", shapes, "low", "high", (1 - math.cos(math.pi / 3)) / 2, (12, 24, 48))


def merged(prefix, faces):
    return {f"{prefix}.{name}": face for name, face in faces.items()}


def occluded():
    for side in (0.25, 0.5, 0.75):
        low, high = 0.5 - side / 2, 0.5 + side / 2
        shapes = {"low": rectangle((0, 1), (0, 1), 0, 1), "high": rectangle((0, 1), (0, 1), 1, -1),
                  "block.up": rectangle((low, high), (low, high), 0.5, 1), "block.down": rectangle((low, high), (low, high), 0.5, -1)}  # fmt: skip
        yield Case("occluded", f"unit squares at 1, a square {side} midway", "derived", shapes, "low", "high", forms.past_square(side, 0.5))
    room = merged("room", box((0, 0, 0), (1, 1, 1), -1))
    for side in (0.2, 0.6):
        low, high = 0.5 - side / 2, 0.5 + side / 2
        inside = merged("box", box((low,) * 3, (high,) * 3, 1))
        scene, ratio = room | inside, side * side
        yield Case("occluded", f"cube {side} in a cube: room to cube", "reciprocity", scene, "room", "box", ratio)
        yield Case("occluded", f"cube {side} in a cube: room to itself", "reciprocity", scene, "room", "room", 1 - ratio)
        face = forms.parallel_rectangles((low, high), (low, high), (0, 1), (0, 1), low)
        yield Case("occluded", f"cube {side} in a cube: its lid to the ceiling", "C-13", scene, "box.z1", "room.z1", face)
    for side, height in ((0.5, 0.5), (0.8, 0.25)):
        low, high = 0.5 - side / 2, 0.5 + side / 2
        plate = {"plate.up": rectangle((low, high), (low, high), height, 1), "plate.down": rectangle((low, high), (low, high), height, -1)}
        form = forms.parallel_rectangles((low, high), (low, high), (0, 1), (0, 1), height)
        yield Case("occluded", f"plate {side} at {height} in a cube: plate to floor", "C-13", room | plate, "plate.down", "room.z0", form)
        yield Case("occluded", f"plate {side} at {height} in a cube: floor to ceiling", "derived", room | plate, "room.z0", "room.z1", forms.past_square(side, height))
        share = 2 * side * side / 6
        yield Case("occluded", f"plate {side} at {height} in a cube: room to itself", "reciprocity", room | plate, "room", "room", 1 - share)
    # MOOSE's test analytical_with_obstruction.i. No line from the floor meets a wall above the plate, for 0.75 x 2 > 1.45.
    # So all lines that the plate stops would end on the ceiling.
    middle = (0.55, 1.45)
    low_room = merged("room", box((0, 0, 0), (2, 2, 1), -1))
    plate = {"plate.up": rectangle(middle, middle, 0.75, 1), "plate.down": rectangle(middle, middle, 0.75, -1)}
    form = forms.equal_rectangles(2, 2, 1) - 0.9**2 / 4 * forms.parallel_rectangles(middle, middle, (0, 2), (0, 2), 0.75)
    yield Case("occluded", "plate 0.9 at 0.75 in a room 2 x 2 x 1: floor to ceiling", "C-11, C-13", low_room | plate, "room.z0", "room.z1", form)


def wall(x, z, y, towards):
    (a, b), (c, d) = x, z
    return Parallelogram((a, y, c), (0, 0, d - c), (b - a, 0, 0)) if towards > 0 else Parallelogram((a, y, c), (b - a, 0, 0), (0, 0, d - c))


def samples():
    """Yields pairs of View3D's sample files with nothing between them; the shapes are where the file has them."""
    unit = lambda x, y, z, up: rectangle((x, x + 1), (y, y + 1), z, up)
    box345, windows = "tests/files/view3d_cases/box345.vs3", "tests/files/view3d_cases/wdwdoor.vs3"
    for a, b, first, second, value in (
        ("Oa-B", "B-2-2", unit(1, 1, 1, -1), unit(1, 1, 0, 1), forms.equal_rectangles(1, 1, 1)),
        ("Ob-T", "T-3-4", unit(3, 2, 2, 1), unit(3, 2, 3, -1), forms.equal_rectangles(1, 1, 1)),
        ("B-1-1", "T-1-1", unit(0, 0, 0, 1), unit(0, 0, 3, -1), forms.equal_rectangles(1, 1, 3)),
        ("B-1-2", "S-1-2", unit(1, 0, 0, 1), wall((1, 2), (0, 1), 0, 1), forms.perpendicular_rectangles(1, 1, 1))):  # fmt: skip
        yield Case("samples", f"box345: {a} to {b}", "C-14" if b[0] == "S" else "C-11", {a: first, b: second}, a, b, value, file=box345)
    floor = rectangle((0, 6), (0, 5), 0, 1)
    door, far_door = wall((1, 2), (0, 2), 0, 1), wall((1, 2), (0, 2), 5, -1)
    window, far_window = wall((3, 5), (1, 2), 0, 1), wall((3, 5), (1, 2), 5, -1)
    for a, b, first, second, source, value in (
        ("z=0", "z=3", floor, rectangle((0, 6), (0, 5), 3, -1), "C-11", forms.equal_rectangles(6, 5, 3)),
        ("z=0", "door:y=0", floor, door, "Ehlert & Smith", forms.perpendicular_apart((0, 5), (0, 6), (1, 2), (0, 2))),
        ("z=0", "wdw:y=5", floor, far_window, "Ehlert & Smith", forms.perpendicular_apart((0, 5), (0, 6), (3, 5), (1, 2))),
        ("door:y=0", "door:y=5", door, far_door, "C-11", forms.equal_rectangles(1, 2, 5)),
        ("wdw:y=0", "door:y=5", window, far_door, "C-13", forms.parallel_rectangles((3, 5), (1, 2), (1, 2), (0, 2), 5))):  # fmt: skip
        yield Case("samples", f"wdwdoor: {a} to {b}", source, {a: first, b: second}, a, b, value, file=windows)


def all_cases():
    return [case for family in (plates, wedges, discs, cylinders, cones, spheres, occluded, samples) for case in family()]
