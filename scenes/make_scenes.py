#!/usr/bin/env python3
"""Makes the example scenes beside this file: run it without arguments.

Fronts, the sides from which corners run counter-clockwise, face the air. Patches that share an edge share its ends.
"""
import math
from pathlib import Path


class Scene:
    """A scene of named faces with shared vertices, written as Wavefront OBJ."""

    def __init__(self):
        self.index = {}
        self.faces = {}  # surface name -> list of vertex index lists

    def add(self, surface, corners):
        face = [self.index.setdefault(tuple(float(x) + 0.0 for x in c), len(self.index) + 1) for c in corners]
        self.faces.setdefault(surface, []).append(face)

    def write(self, name, title):
        with open(Path(__file__).parent / name, "w", encoding="utf-8") as out:
            out.write(f"# {title}; metres; made by make_scenes.py\n")
            for vertex in self.index:
                out.write("v {!r} {!r} {!r}\n".format(*vertex))
            for surface, faces in self.faces.items():
                out.write(f"o {surface}\n")
                for face in faces:
                    out.write("f " + " ".join(map(str, face)) + "\n")


def turned(points, centre, angle_deg):
    """Returns points turned about the vertical through `centre`."""
    c, s = math.cos(math.radians(angle_deg)), math.sin(math.radians(angle_deg))
    return [(centre[0] + c * (x - centre[0]) - s * (y - centre[1]), centre[1] + s * (x - centre[0]) + c * (y - centre[1]), z)
            for x, y, z in points]


def add_patches(scene, name_of, fixed_axis, at, a_lines, b_lines, flip):
    """Adds patches of the plane where coordinate `fixed_axis` is `at`. a and b are the next two axes, and the front faces
    +fixed_axis unless `flip`. name_of(a, b) names the patch with this centre; None leaves it out."""
    a_axis, b_axis = (fixed_axis + 1) % 3, (fixed_axis + 2) % 3
    for a0, a1 in zip(a_lines, a_lines[1:]):
        for b0, b1 in zip(b_lines, b_lines[1:]):
            name = name_of((a0 + a1) / 2, (b0 + b1) / 2)
            if name is None:
                continue
            corners = []
            for a, b in ((a0, b0), (a1, b0), (a1, b1), (a0, b1)):
                p = [0.0, 0.0, 0.0]
                p[fixed_axis], p[a_axis], p[b_axis] = at, a, b
                corners.append(tuple(p))
            scene.add(name, corners[::-1] if flip else corners)


def add_box(scene, name, low, high, angle_deg=0, inward=False, names=None):
    """Adds a closed box, turned about its vertical axis."""
    centre = ((low[0] + high[0]) / 2, (low[1] + high[1]) / 2)
    box = Scene()
    for axis in range(3):
        a, b = (axis + 1) % 3, (axis + 2) % 3
        for upper in (0, 1):
            face = names[2 * axis + upper] if names else name
            add_patches(box, lambda *_: face, axis, (low, high)[upper][axis], (low[a], high[a]), (low[b], high[b]), (upper == 0) != inward)
    vertices = list(box.index)
    if angle_deg:
        vertices = turned(vertices, centre, angle_deg)
    for face, loops in box.faces.items():
        for loop in loops:
            scene.add(face, [vertices[k - 1] for k in loop])


def add_prism(scene, name, centre, radius, low, high, sides):
    """Adds a closed upright prism with a regular base."""
    ring = [(centre[0] + radius * math.cos(2 * math.pi * k / sides), centre[1] + radius * math.sin(2 * math.pi * k / sides))
            for k in range(sides)]
    scene.add(name, [(x, y, high) for x, y in ring])
    scene.add(name, [(x, y, low) for x, y in reversed(ring)])
    for (x0, y0), (x1, y1) in zip(ring, ring[1:] + ring[:1]):
        scene.add(name, [(x0, y0, low), (x1, y1, low), (x1, y1, high), (x0, y0, high)])


def make_office():
    """Returns a closed room, 6 x 4 x 2.8 m. Furniture stands on glides of 1 cm, so that no solids touch."""
    scene = Scene()
    x_lines = [k / 2 for k in range(13)]
    y_lines = [k / 2 for k in range(9)]
    z_lines = [0, 0.45, 0.9, 1.5, 2.1, 2.8]

    def north(z, x):
        if 0.9 < z < 2.1:
            if 1 < x < 2.5:
                return "window_1"
            if 3.5 < x < 5:
                return "window_2"
        return "wall_north"

    def west(y, z):
        return "door" if 0.5 < y < 1.5 and z < 2.1 else "wall_west"

    add_patches(scene, lambda *_: "floor", 2, 0.0, x_lines, y_lines, False)
    add_patches(scene, lambda *_: "ceiling", 2, 2.8, x_lines, y_lines, True)
    add_patches(scene, lambda *_: "wall_south", 1, 0.0, z_lines, x_lines, False)
    add_patches(scene, north, 1, 4.0, z_lines, x_lines, True)
    add_patches(scene, west, 0, 0.0, y_lines, z_lines, False)
    add_patches(scene, lambda *_: "wall_east", 0, 6.0, y_lines, z_lines, True)

    # The desk below the second window is a board and four legs, 2 mm apart, so that no solids touch.
    add_box(scene, "desk", (3.4, 2.7, 0.72), (5.2, 3.5, 0.75))
    for x in (3.45, 5.09):
        for y in (2.75, 3.39):
            add_box(scene, "desk", (x, y, 0.01), (x + 0.06, y + 0.06, 0.718))
    add_box(scene, "monitor", (4.0, 3.2, 0.76), (4.6, 3.24, 1.12), 8)

    # Shelves stand along the east wall: two sides, a back, five boards, and boxes on the boards.
    add_box(scene, "shelves", (5.6, 0.30, 0.01), (5.98, 0.33, 1.90))
    add_box(scene, "shelves", (5.6, 1.67, 0.01), (5.98, 1.70, 1.90))
    add_box(scene, "shelves", (5.955, 0.335, 0.01), (5.98, 1.665, 1.90))
    for k in range(5):
        z = 0.10 + 0.42 * k
        add_box(scene, "shelves", (5.6, 0.335, z), (5.95, 1.665, z + 0.025))
    for k, (y, width, height, angle) in enumerate([(0.45, 0.30, 0.25, 0), (1.10, 0.35, 0.20, 5), (0.60, 0.25, 0.30, -9),
                                                   (1.20, 0.28, 0.15, 0), (0.50, 0.40, 0.22, 3), (1.15, 0.20, 0.28, -4)]):
        z = 0.10 + 0.42 * (k // 2 + 1) + 0.03
        add_box(scene, "boxes", (5.66, y, z), (5.88, y + width, z + height), angle)

    add_box(scene, "radiator", (1.1, 3.85, 0.15), (2.4, 3.95, 0.75))
    add_box(scene, "cabinet", (0.05, 2.2, 0.01), (0.50, 3.4, 1.20))
    add_prism(scene, "lamp", (3.0, 2.0), 0.30, 2.45, 2.70, 8)
    add_box(scene, "person", (2.0, 1.2, 0.01), (2.5, 1.5, 1.75), 33)

    # The chair is turned as a whole.
    chair = Scene()
    add_box(chair, "chair", (4.1, 1.9, 0.45), (4.55, 2.35, 0.49))
    add_box(chair, "chair", (4.1, 1.9, 0.50), (4.55, 1.94, 0.95))
    for x in (4.11, 4.50):
        for y in (1.91, 2.30):
            add_box(chair, "chair", (x, y, 0.01), (x + 0.04, y + 0.04, 0.448))
    vertices = turned(list(chair.index), (4.325, 2.125), 17)
    for loop in chair.faces["chair"]:
        scene.add("chair", [vertices[k - 1] for k in loop])
    scene.write("office.obj", "Office: a closed room with furniture")


def make_street():
    """Returns a street between two rows of buildings under open sky. There is no ground below the buildings."""
    scene = Scene()
    y_lines = [4 * k for k in range(16)]
    in_building = lambda y: y % 16 < 12
    add_patches(scene, lambda x, y: "road", 2, 0.0, [-4, 0, 4], y_lines, False)
    add_patches(scene, lambda x, y: "pavement_west" if x < 0 else "pavement_east", 2, 0.0, [-6, -4], y_lines, False)
    add_patches(scene, lambda x, y: "pavement_east", 2, 0.0, [4, 6], y_lines, False)
    for x_lines in ([-14, -10, -6], [6, 10, 14]):
        add_patches(scene, lambda x, y: None if in_building(y) else "lanes", 2, 0.0, x_lines, y_lines, False)
    heights = [[8, 12, 8, 16], [12, 8, 16, 8]]
    for row, x_lines in enumerate(([-14, -10, -6], [6, 10, 14])):
        for k, height in enumerate(heights[row]):
            name = f"building_{'we'[row]}{k + 1}"
            lines = [16 * k + 4 * j for j in range(4)]
            z_lines = [4 * j for j in range(height // 4 + 1)]
            add_patches(scene, lambda *_: name, 0, x_lines[0], lines, z_lines, True)
            add_patches(scene, lambda *_: name, 0, x_lines[-1], lines, z_lines, False)
            add_patches(scene, lambda *_: name, 1, lines[0], z_lines, x_lines, True)
            add_patches(scene, lambda *_: name, 1, lines[-1], z_lines, x_lines, False)
            roof = "roof" + name[len("building"):]
            if (row, k) == (0, 1):  # a gabled one
                y0, y1, ridge = lines[0], lines[-1], height + 3
                x0, x1, x2 = x_lines
                for j in range(3):
                    ya, yb = lines[j], lines[j + 1]
                    scene.add(roof, [(x0, ya, height), (x1, ya, ridge), (x1, yb, ridge), (x0, yb, height)])
                    scene.add(roof, [(x1, ya, ridge), (x2, ya, height), (x2, yb, height), (x1, yb, ridge)])
                scene.add(name, [(x0, y0, height), (x1, y0, height), (x1, y0, ridge)])
                scene.add(name, [(x1, y0, height), (x2, y0, height), (x1, y0, ridge)])
                scene.add(name, [(x1, y1, height), (x0, y1, height), (x1, y1, ridge)])
                scene.add(name, [(x2, y1, height), (x1, y1, height), (x1, y1, ridge)])
            else:
                add_patches(scene, lambda *_: roof, 2, height, x_lines, lines, False)
    scene.write("street.obj", "Street between buildings under open sky")


def make_small():
    cube = Scene()
    add_box(cube, "", (0, 0, 0), (1, 1, 1), inward=True, names=["x0", "x1", "y0", "y1", "z0", "z1"])
    cube.write("cube.obj", "Inside of a unit cube")
    plates = Scene()
    plates.add("lower", [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    plates.add("upper", [(0, 0, 1), (0, 1, 1), (1, 1, 1), (1, 0, 1)])
    plates.write("plates.obj", "Two unit squares that face each other at distance 1")
    past = Scene()
    past.add("lower", [(0, 0, 0), (0.5, 0, 0), (0.5, 0.5, 0), (0, 0.5, 0)])
    past.add("upper", [(0, 0, 6), (0, 0.5, 6), (0.5, 0.5, 6), (0.5, 0, 6)])
    past.add("blocker", [(-0.1, -1, 3), (0.4, -1, 3), (0.4, 1, 3), (-0.1, 1, 3)])
    past.write("past_edge.obj", "Two squares far apart that see each other past an edge: one direction in 200 or so meets the two")


if __name__ == "__main__":
    make_office()
    make_street()
    make_small()
