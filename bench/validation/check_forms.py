"""Compares every closed form with a numerical integral that uses none of them.

Rays start at points uniform over the emitting shape and follow the cosine law, both of scrambled Sobol' points. The
form factor is the share of rays whose first hit among the true shapes is the target. Replicates give a standard error.
For pairs of flat shapes with nothing between, Lambert's formula for the target seen from a point is integrated over the
emitter. Gauss rules do so on cells that shrink towards its edges; two rules give the error. Small values need this.
"""
import math

import numpy as np
from scipy.stats import qmc, t as student

REPLICATES, LOG2_RAYS = 16, (13, 15, 17)
FALSE_ALARM = 1e-6  # probability that a right form is found wrong in one comparison
WRONG = 1.05  # negative control: a form times this number must be found wrong


def by_rays(case, log2_rays, seed=1):
    """Returns (estimate, standard error)."""
    shares = []
    source = case.shapes
    emitters = [name for name in source if name == case.source_shape or name.startswith(case.source_shape + ".")]
    for replicate in range(REPLICATES):
        numbers = qmc.Sobol(5, seed=1000 * seed + replicate).random_base2(log2_rays)
        if len(emitters) == 1:
            points, normals = source[emitters[0]].sample(numbers[:, 0], numbers[:, 1])
        else:  # flat faces, chosen by area
            areas = np.array([source[name].area for name in emitters])
            chosen = np.searchsorted(np.cumsum(areas) / areas.sum(), numbers[:, 4], side="right")
            points, normals = np.empty((len(numbers), 3)), np.empty((len(numbers), 3))
            for k, name in enumerate(emitters):
                points[chosen == k], normals[chosen == k] = source[name].sample(numbers[chosen == k, 0], numbers[chosen == k, 1])
        # first and second complete the normal to a frame.
        other = np.where(np.abs(normals[:, [2]]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
        first = np.cross(other, normals)
        first /= np.linalg.norm(first, axis=1)[:, None]
        second = np.cross(normals, first)
        ring, angle = np.sqrt(numbers[:, 2]), 2 * np.pi * numbers[:, 3]
        directions = first * (ring * np.cos(angle))[:, None] + second * (ring * np.sin(angle))[:, None]
        directions += normals * np.sqrt(1 - numbers[:, 2])[:, None]
        nearest = np.full(len(points), np.inf)
        hit_target = np.zeros(len(points), bool)
        for name, shape in source.items():
            distance = shape.hit(points, directions)
            closer = distance < nearest
            nearest = np.where(closer, distance, nearest)
            is_target = name == case.target or name.startswith(case.target + ".")
            hit_target = np.where(closer, is_target, hit_target)
        shares.append(hit_target.mean())
    return float(np.mean(shares)), float(np.std(shares, ddof=1) / math.sqrt(REPLICATES))


def lambert(points, normal, corners):
    """Returns form factors from points to a polygon in front of them."""
    total = np.zeros(len(points))
    spokes = [corner - points for corner in corners]
    for a, b in zip(spokes, spokes[1:] + spokes[:1]):
        cross = np.cross(a, b)
        length = np.linalg.norm(cross, axis=1)
        angle = np.arctan2(length, np.einsum("ij,ij->i", a, b))
        total += angle * (cross @ normal) / length
    return np.abs(total) / (2 * math.pi)


def by_lambert(case, gauss):
    source, target = case.shapes[case.source_shape], case.shapes[case.target]
    nodes, weights = np.polynomial.legendre.leggauss(gauss)
    # Cells of (0, 1) that shrink by 4 towards both ends.
    ends = [0.0] + [0.5 * 4.0**-k for k in range(14, -1, -1)]
    ends += [1 - e for e in ends[-2::-1]]
    at = np.concatenate([(b + a) / 2 + (b - a) / 2 * nodes for a, b in zip(ends, ends[1:])])
    weight = np.concatenate([(b - a) / 2 * weights for a, b in zip(ends, ends[1:])])
    u, v = (x.ravel() for x in np.meshgrid(at, at))
    points, _ = source.sample(u, v)
    return float(np.outer(weight, weight).ravel() @ lambert(points, source.normal, target.corners()))


def is_flat_pair(case):
    return len(case.shapes) == 2 and all(shape.is_flat for shape in case.shapes.values())


def integral_of(case):
    """Returns (integral, how far a closed form may be from it)."""
    if is_flat_pair(case):
        integral = by_lambert(case, 6)
        # The distance of the two rules is about the error of the coarser one, which exceeds that of the finer one. Closed
        # forms round to 1e-12, and ten times that is added.
        return integral, abs(integral - by_lambert(case, 4)) + 1e-11
    for log2_rays in LOG2_RAYS:
        integral, error = by_rays(case, log2_rays)
        # Where all rays agree, replicates have no spread: the error is then at least one ray of all.
        error = max(error, 1 / (REPLICATES * 2**log2_rays))
        allowed = student.ppf(1 - FALSE_ALARM / 2, REPLICATES - 1) * error
        if allowed < (WRONG - 1) / 1.5 * integral:  # exact enough to find a form times WRONG wrong
            break
    return integral, allowed


def check_forms(cases):
    """Returns (case, fault) for each wrong form. Negative control: each form times WRONG must be found wrong, too."""
    complaints = []
    for case in cases:
        integral, allowed = integral_of(case)
        if abs(integral - case.value) > allowed:
            complaints.append((case, f"the form says {case.value:.9g}, the integral {integral:.9g} +- {allowed:.1e}"))
        elif abs(integral - case.value * WRONG) <= allowed:
            complaints.append((case, f"{WRONG} times the form was not found wrong"))
    return complaints
