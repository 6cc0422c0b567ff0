"""These are closed forms of form factors, each with its source. Numbers C-n are from J. R. Howell, A Catalog of
Radiation Heat Transfer Configuration Factors. bench/validate --forms compares each with a numerical integral that uses
none of them."""
from math import acos, asin, atan, cos, hypot, log, pi, sin, sqrt

from scipy.integrate import quad


def parallel_rectangles(x, y, xi, eta, z):
    """Returns F from x times y at height 0 to xi times eta at height z: C-13, J. R. Ehlert and T. F. Smith, J.
    Thermophysics and Heat Transfer 7(1), 1993."""

    def term(p, q):
        a, b = hypot(p, z), hypot(q, z)
        return (q * a * atan(q / a) + p * b * atan(p / b) - z * z / 2 * log(p * p + q * q + z * z)) / (2 * pi)

    total = sum((-1) ** (i + j + k + l) * term(x[i] - xi[k], y[j] - eta[l]) for i in (0, 1) for j in (0, 1) for k in (0, 1) for l in (0, 1))
    return total / ((x[1] - x[0]) * (y[1] - y[0]))


def equal_rectangles(a, b, c):
    """Returns F between opposite rectangles a times b at distance c: C-11."""
    x, y = a / c, b / c
    return (2 / (pi * x * y) * (log(sqrt((1 + x * x) * (1 + y * y) / (1 + x * x + y * y)))
            + x * sqrt(1 + y * y) * atan(x / sqrt(1 + y * y)) + y * sqrt(1 + x * x) * atan(y / sqrt(1 + x * x)) - x * atan(x) - y * atan(y)))  # fmt: skip


def perpendicular_rectangles(height, length, width):
    """Returns F from width times length to height times length, with a common edge of this length: C-14."""
    h, w = height / length, width / length
    r = sqrt(h * h + w * w)
    return (w * atan(1 / w) + h * atan(1 / h) - r * atan(1 / r) + log(
        (1 + w * w) * (1 + h * h) / (1 + r * r)
        * (w * w * (1 + r * r) / ((1 + w * w) * r * r)) ** (w * w)
        * (h * h * (1 + r * r) / ((1 + h * h) * r * r)) ** (h * h)) / 4) / (pi * w)  # fmt: skip


def perpendicular_apart(x, y, eta, zeta):
    """Returns F from x times y in the plane z = 0 to eta times zeta in the plane x = 0: Ehlert and Smith as above."""

    def term(square, q):
        root = sqrt(square)
        return (q * root * atan(q / root) if root > 0 else 0) - ((square - q * q) / 4 * log(square + q * q) if square + q * q > 0 else 0)

    total = sum((-1) ** (i + j + k + l) * term(x[i] ** 2 + zeta[k] ** 2, y[j] - eta[l]) for i in (0, 1) for j in (0, 1) for k in (0, 1) for l in (0, 1))
    return total / (2 * pi * (x[1] - x[0]) * (y[1] - y[0]))


def wedge(from_width, to_width, length, angle):
    """Returns F from a rectangle to another with a common edge, at any angle. C-16 leaves one integral; so does E. M.
    Sparrow's contour integral (1963), 1 / (2 pi A) times the sum of integrals of ln r along both contours, used here.
    Edges across the common edge are at right angles to edges along it and add nothing. Two double integrals are left,
    and the inner one of each is elementary."""

    def along(p, q):
        # Returns the integral of ln r over two edges along the common edge, which are a distance d apart.
        d = sqrt(max(0.0, p * p + q * q - 2 * p * q * cos(angle)))
        if d == 0:
            return length * length * (log(length) - 1.5)
        return (length**2 - d * d) / 2 * log(length**2 + d * d) - 1.5 * length**2 + 2 * d * length * atan(length / d) + d * d * log(d)

    def across(offset):
        # Returns the integral of ln r over two edges that leave the common edge, from one corner (offset 0) or from its
        # two corners.
        def inner(p):
            foot, height = p * cos(angle), hypot(p * sin(angle), offset)

            def antiderivative(s):
                square = s * s + height * height
                return (s * log(square) / 2 if square > 0 else 0) - s + (height * atan(s / height) if height > 0 else 0)

            return antiderivative(to_width - foot) - antiderivative(-foot)

        breaks = sorted({min(from_width, to_width * k) for k in (0.5, 1)})
        return quad(inner, 0, from_width, points=breaks, limit=400, epsabs=1e-14, epsrel=1e-13)[0]

    # Directions of the contours: common edges run opposite ways, and so on around.
    lengthwise = -along(0, 0) + along(from_width, 0) + along(0, to_width) - along(from_width, to_width)
    crosswise = 2 * cos(angle) * (across(length) - across(0))
    return (lengthwise + crosswise) / (2 * pi * from_width * length)


def coaxial_discs(first, second, distance):
    """Returns F from the disc of radius `first`: C-41."""
    s, x = second / first, 1 + (second**2 + distance**2) / first**2
    return 2 * s * s / (x + sqrt(x * x - 4 * s * s))


def annulus_to_disc(inner, outer, disc, distance):
    """Returns F from the annulus to a coaxial disc, by sums and differences of C-41."""
    flow = outer**2 * coaxial_discs(outer, disc, distance) - (inner**2 * coaxial_discs(inner, disc, distance) if inner else 0)
    return flow / (outer**2 - inner**2)


def annuli(inner, outer, to_inner, to_outer, distance):
    """Returns F between annuli, by sums and differences of C-41."""
    return annulus_to_disc(inner, outer, to_outer, distance) - annulus_to_disc(inner, outer, to_inner, distance)


def cylinder_to_itself(radius, height):
    """Returns F from the inner side of a cylinder to itself: Howell's catalogue."""
    h = height / (2 * radius)
    return 1 + h - sqrt(1 + h * h)


def cylinder_base_to_side(radius, height):
    """Returns F inside a cylinder from its base to its side: Howell's catalogue."""
    h = height / (2 * radius)
    return 2 * h * (sqrt(1 + h * h) - h)


def cylinder_rings(radius, first, second, gap):
    """Returns F inside a cylinder from a ring of the side to another at a gap, by sums and differences of C-41."""
    ends = lambda h: pi * radius**2 * (coaxial_discs(radius, radius, h) if h > 0 else 1)
    flow = ends(gap) - ends(gap + first) - ends(gap + second) + ends(gap + first + second)
    return flow / (2 * pi * radius * first)


def outer_to_inner_cylinder(inner, outer, height):
    """Returns F from the outer to the inner of two cylinders of one height: Howell's catalogue."""
    r, h = outer / inner, height / inner
    a, b = h * h + r * r - 1, h * h - r * r + 1
    return (1 - (acos(b / a) - (sqrt((a + 2) ** 2 - 4 * r * r) * acos(b / (r * a)) + b * asin(1 / r) - pi * a / 2) / (2 * h)) / pi) / r


def outer_cylinder_to_itself(inner, outer, height):
    """Returns F from the outer cylinder to itself, past the inner one: Howell's catalogue."""
    r, h = outer / inner, height / inner
    root = sqrt(4 * r * r + h * h)
    return 1 - 1 / r + 2 / (pi * r) * atan(2 * sqrt(r * r - 1) / h) - h / (2 * pi * r) * (
        root / h * asin((4 * (r * r - 1) + h * h / (r * r) * (r * r - 2)) / (h * h + 4 * (r * r - 1)))
        - asin((r * r - 2) / (r * r)) + pi / 2 * (root / h - 1))  # fmt: skip


def inner_cylinder_to_end(inner, outer, height):
    """Returns F from the inner side to one annular end: half of what the outer side leaves of 1."""
    return (1 - outer / inner * outer_to_inner_cylinder(inner, outer, height)) / 2


def outer_cylinder_to_end(inner, outer, height):
    """Returns F from the outer side to one annular end."""
    return (1 - outer_to_inner_cylinder(inner, outer, height) - outer_cylinder_to_itself(inner, outer, height)) / 2


def end_to_end(inner, outer, height):
    """Returns F between the annular ends, by closure and reciprocity."""
    area, side = pi * (outer**2 - inner**2), 2 * pi * height
    return 1 - side * (inner * inner_cylinder_to_end(inner, outer, height) + outer * outer_cylinder_to_end(inner, outer, height)) / area


def sphere_to_disc(disc, distance):
    """Returns F from a sphere to a coaxial disc: the solid angle of the disc at the sphere's centre, over 4 pi."""
    return (1 - 1 / sqrt(1 + (disc / distance) ** 2)) / 2


def sphere_to_corner(a, b, distance):
    """Returns F from a sphere to a rectangle a times b, whose corner is nearest to the centre: solid angle over 4 pi."""
    return atan(a * b / (distance * sqrt(a * a + b * b + distance**2))) / (4 * pi)


def past_square(side, height):
    """Returns F between unit squares at distance 1 with a parallel square of this side over their middle, at this height.
    Take lines whose two ends differ by d >= 0 in one coordinate; those of the other sign mirror them. They start within
    1 - d of length, and the square stops the part from which they pass its height between its edges. So one double
    integral of a smooth kernel is left, with kinks where an end of this part meets an end of the range."""
    first, last = (1 - side) / 2, (1 + side) / 2
    kinks = (first / height, first / (1 - height), last / height, last / (1 - height))
    ends = sorted({0, 1, *(d for d in kinks if 0 < d < 1)})

    def stopped(d):
        return max(0, min(1 - d, last - height * d) - max(0, first - height * d))

    def kernel(p, q):
        return stopped(p) * stopped(q) / (pi * (1 + p * p + q * q) ** 2)

    pieces = list(zip(ends, ends[1:]))
    rule = [quad(lambda p: quad(lambda q: kernel(p, q), *of_q, epsabs=1e-13)[0], *of_p, epsabs=1e-13)[0] for of_p in pieces for of_q in pieces]
    return equal_rectangles(1, 1, 1) - 4 * sum(rule)
