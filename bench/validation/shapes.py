"""These shapes of the validation have faces for viewpeel, and points and ray hits for the check of closed forms.

mesh(n): faces as lists of corners, counter-clockwise seen from the side that radiates; n pieces around an axis.
sample(u, v): points and normals uniform over the true surface, for u, v in (0, 1).
hit(origins, directions): distance along each ray to the true surface, inf where there is none.
"""
import math

import numpy as np

NEAR = 1e-7  # hits nearer than this are the ray's own start


def area_vector(corners):
    corners = np.asarray(corners, float)
    return sum(np.cross(corners[k] - corners[0], corners[k + 1] - corners[0]) for k in range(1, len(corners) - 1)) / 2


def towards(corners, normal):
    """Returns the corners in the order whose normal is nearer to the given one."""
    return corners if np.dot(area_vector(corners), normal) > 0 else corners[::-1]


class Parallelogram:
    is_flat = True

    def __init__(self, origin, u, v):
        self.origin, self.u, self.v = (np.array(x, float) for x in (origin, u, v))
        normal = np.cross(self.u, self.v)
        self.area = np.linalg.norm(normal)
        self.normal = normal / self.area

    def corners(self):
        return [self.origin, self.origin + self.u, self.origin + self.u + self.v, self.origin + self.v]

    def mesh(self, n):
        return [self.corners()]

    def sample(self, u, v):
        return self.origin + np.outer(u, self.u) + np.outer(v, self.v), np.broadcast_to(self.normal, (len(u), 3))

    def hit(self, origins, directions):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = ((self.origin - origins) @ self.normal) / (directions @ self.normal)
            at = origins + directions * t[:, None] - self.origin
            # Coordinates in the basis u, v, which need not be orthogonal.
            dual = np.linalg.inv(np.array([self.u, self.v, self.normal]))
            a, b, _ = (at @ dual).T
            inside = (t > NEAR) & (a >= 0) & (a <= 1) & (b >= 0) & (b <= 1)
        return np.where(inside, t, np.inf)


class Disc:
    """An annulus about the z axis, or a disc; up: +1 or -1, the side that radiates."""

    is_flat = False

    def __init__(self, z, outer, inner=0.0, up=1):
        self.z, self.outer, self.inner, self.up = z, outer, inner, up

    def mesh(self, n):
        ring = [(math.cos(2 * math.pi * k / n), math.sin(2 * math.pi * k / n)) for k in range(n)]
        at = lambda radius, k: (radius * ring[k % n][0], radius * ring[k % n][1], self.z)
        normal = (0, 0, self.up)
        if self.inner == 0:
            return [towards([at(self.outer, k) for k in range(n)], normal)]
        return [towards([at(self.inner, k), at(self.outer, k), at(self.outer, k + 1), at(self.inner, k + 1)], normal) for k in range(n)]

    def sample(self, u, v):
        radius, angle = np.sqrt(self.inner**2 + (self.outer**2 - self.inner**2) * u), 2 * np.pi * v
        points = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full_like(u, self.z)], 1)
        return points, np.broadcast_to([0, 0, self.up], (len(u), 3))

    def hit(self, origins, directions):
        with np.errstate(divide="ignore", invalid="ignore"):
            t = (self.z - origins[:, 2]) / directions[:, 2]
            at = origins + directions * t[:, None]
            squared = at[:, 0] ** 2 + at[:, 1] ** 2
            inside = (t > NEAR) & (squared <= self.outer**2) & (squared >= self.inner**2)
        return np.where(inside, t, np.inf)


class Sphere:
    """A zone of a sphere about a point of the z axis, between two polar angles. out: +1 or -1, the side that radiates:
    the outer or the inner one."""

    is_flat = False

    def __init__(self, z, radius, out=1, polar=(0.0, math.pi)):
        self.z, self.radius, self.out, self.polar = z, radius, out, polar

    def mesh(self, n):
        low, high = self.polar
        rows = max(1, round(n / 2 * (high - low) / math.pi))
        at = lambda row, k: np.array([math.sin(row) * math.cos(k), math.sin(row) * math.sin(k), math.cos(row)])
        faces = []
        for row in range(rows):
            a, b = (low + (high - low) * (row + i) / rows for i in (0, 1))
            for k in range(n):
                left, right = 2 * math.pi * k / n, 2 * math.pi * (k + 1) / n
                ring = [at(a, left), at(b, left)]
                if b < math.pi - 1e-12:
                    ring.append(at(b, right))
                if a > 1e-12:
                    ring.append(at(a, right))
                corners = [self.radius * c + (0, 0, self.z) for c in ring]
                faces.append(towards(corners, self.out * sum(ring)))
        return faces

    def sample(self, u, v):
        low, high = math.cos(self.polar[1]), math.cos(self.polar[0])
        height, angle = low + (high - low) * u, 2 * np.pi * v
        ring = np.sqrt(np.maximum(0, 1 - height**2))
        normals = np.stack([ring * np.cos(angle), ring * np.sin(angle), height], 1)
        return self.radius * normals + (0, 0, self.z), self.out * normals

    def hit(self, origins, directions):
        from_centre = origins - (0, 0, self.z)
        along = np.einsum("ij,ij->i", from_centre, directions)
        root = along**2 - np.einsum("ij,ij->i", from_centre, from_centre) + self.radius**2
        low, high = math.cos(self.polar[1]), math.cos(self.polar[0])
        nearest = np.full(len(origins), np.inf)
        with np.errstate(invalid="ignore"):
            for sign in (1, -1):
                t = -along + sign * np.sqrt(root)
                height = (from_centre[:, 2] + t * directions[:, 2]) / self.radius
                inside = (root >= 0) & (t > NEAR) & (height >= low) & (height <= high)
                nearest = np.where(inside & (t < nearest), t, nearest)
        return nearest


class Cone:
    """The side of a cylinder, a cone or its frustum about the z axis. out: +1 or -1, the side that radiates: the outer or
    the inner one."""

    is_flat = False

    def __init__(self, z, radius, out=1):
        self.z, self.radius, self.out = z, radius, out  # pairs: of the lower and the upper end
        self.slope = (radius[1] - radius[0]) / (z[1] - z[0])

    def mesh(self, n):
        at = lambda end, k: (self.radius[end] * math.cos(2 * math.pi * k / n), self.radius[end] * math.sin(2 * math.pi * k / n), self.z[end])
        faces = []
        for k in range(n):
            corners = [at(0, k), at(0, k + 1)] if self.radius[0] > 0 else [at(0, k)]
            corners += [at(1, k + 1), at(1, k)] if self.radius[1] > 0 else [at(1, k)]
            middle = math.pi * (2 * k + 1) / n
            faces.append(towards(corners, self.out * np.array([math.cos(middle), math.sin(middle), -self.slope])))
        return faces

    def sample(self, u, v):
        a, b = self.radius
        radius = np.sqrt(a * a + (b * b - a * a) * u) if a != b else np.full_like(u, a)
        share = (radius - a) / (b - a) if a != b else u
        angle = 2 * np.pi * v
        points = np.stack([radius * np.cos(angle), radius * np.sin(angle), self.z[0] + (self.z[1] - self.z[0]) * share], 1)
        normals = np.stack([np.cos(angle), np.sin(angle), np.full_like(u, -self.slope)], 1) / math.hypot(1, self.slope)
        return points, self.out * normals

    def hit(self, origins, directions):
        # x^2 + y^2 = (radius[0] + slope (z - z[0]))^2
        x, y, z = origins.T
        dx, dy, dz = directions.T
        ring, grow = self.radius[0] + self.slope * (z - self.z[0]), self.slope * dz
        a, b, c = dx * dx + dy * dy - grow**2, x * dx + y * dy - ring * grow, x * x + y * y - ring**2
        nearest = np.full(len(origins), np.inf)
        with np.errstate(divide="ignore", invalid="ignore"):
            root = np.sqrt(b * b - a * c)
            for sign in (1, -1):
                t = (-b + sign * root) / a
                height = z + t * dz
                inside = (t > NEAR) & (height >= self.z[0]) & (height <= self.z[1]) & (ring + grow * t >= 0)
                nearest = np.where(inside & (t < nearest), t, nearest)
        return nearest


def box(low, high, out):
    """Returns the six faces of a box: x0, x1, y0, y1, z0, z1; out: +1 or -1, the side that radiates."""
    (x, y, z), (a, b, c) = low, np.subtract(high, low)
    faces = {}
    for axis, (u, v) in enumerate((((0, b, 0), (0, 0, c)), ((0, 0, c), (a, 0, 0)), ((a, 0, 0), (0, b, 0)))):
        for end in (0, 1):
            origin = np.array([x, y, z], float)
            origin[axis] = (low, high)[end][axis]
            first, second = (u, v) if (end == 1) == (out > 0) else (v, u)
            faces["xyz"[axis] + str(end)] = Parallelogram(origin, first, second)
    return faces
