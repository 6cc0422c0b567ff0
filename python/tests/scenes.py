"""These scenes are shared by tests."""

import os
import signal

import numpy

# Some tests send themselves Ctrl-C. A shell lets processes in the background ignore it, and the runs would not end.
signal.signal(signal.SIGINT, signal.default_int_handler)

SOURCE = os.environ["VIEWPEEL_SOURCE"]
PROGRAM = os.environ["VIEWPEEL_PROGRAM"]

# Two unit squares face each other at distance 1. Howell's catalogue, C-11:
# F = 2 / pi (ln(2 / sqrt(3)) + 2 sqrt(2) atan(1 / sqrt(2)) - 2 atan(1)).
PLATES_F = 2 / numpy.pi * (
    numpy.log(2 / numpy.sqrt(3)) + 2 * numpy.sqrt(2) * numpy.arctan(1 / numpy.sqrt(2)) - 2 * numpy.arctan(1)
)  # fmt: skip
PLATE_POINTS = numpy.array(
    [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]], dtype=float
)
PLATES = numpy.array([[0, 1, 2, 3], [4, 7, 6, 5]])


def scene_file(name: str) -> str:
    return os.path.join(SOURCE, "scenes", name)
