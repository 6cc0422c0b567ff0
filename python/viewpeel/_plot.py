"""plot() draws a result."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy

if TYPE_CHECKING:
    from ._result import Result

_MOST_CELLS = 1000  # cells across the picture; with more rows a cell shows the largest of several form factors
_MOST_NAMES = 25


def _cells(result: "Result") -> Any:
    """Returns F as a dense picture; each cell is the largest form factor in it, or NaN where all are 0."""
    pairs, count = result.form_factors.tocoo(), len(result)
    across = min(count, _MOST_CELLS)
    picture = numpy.zeros((across, across))
    numpy.maximum.at(picture, (pairs.row * across // count, pairs.col * across // count), pairs.data)
    picture[picture <= 0] = numpy.nan
    return picture


def plot(result: "Result") -> Any:
    from matplotlib.colors import LogNorm
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 4.5), layout="constrained")
    matrix, histogram = figure.subplots(1, 2)
    picture = _cells(result)
    if numpy.isfinite(picture).any():
        largest = float(numpy.nanmax(picture))
        shown = matrix.imshow(
            picture,
            norm=LogNorm(vmin=max(float(numpy.nanmin(picture)), 1e-6 * largest), vmax=largest),
            extent=(-0.5, len(result) - 0.5, len(result) - 0.5, -0.5),
            interpolation="nearest",
        )
        figure.colorbar(shown, ax=matrix, label="form factor")
    matrix.set(xlabel="to", ylabel="from")
    if len(result) <= _MOST_NAMES:
        matrix.set_xticks(range(len(result)), result.names, rotation=90)
        matrix.set_yticks(range(len(result)), result.names)
    errors = result.standard_errors.data
    errors = errors[numpy.isfinite(errors) & (errors > 0)]
    if errors.size:
        low, high = numpy.log10(errors.min()), numpy.log10(errors.max())
        histogram.hist(errors, bins=numpy.logspace(low, max(high, low + 0.1), 40))
        histogram.set_xscale("log")
    histogram.set(xlabel="standard error", ylabel="form factors")
    return figure
