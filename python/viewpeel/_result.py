"""A Result gives sparse matrices, arrays of rows, tables, pictures and files."""

from __future__ import annotations

import html
import os
import tempfile
from functools import cached_property
from typing import Any, Callable, NamedTuple, Optional, Sequence, Union

import numpy
from numpy.typing import NDArray
from scipy.sparse import csr_array

from . import _core

Floats = NDArray[numpy.float64]


class Closure(NamedTuple):
    """The distances of row sums from 1: the largest with its standard error, the rms, and the row of the largest."""

    largest: float
    standard_error: float
    rms: float
    row: str


def _number(text: str) -> Union[int, float, str]:
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


class Result:
    """Form factors of n rows, with their errors. Rows are in the order of the scene; empty rows keep their places.

    Sparse matrices are n x n; entry [i, j] is from row i to row j, and F_ij is without unit. Arrays that share memory
    with the library cannot change the files that save() writes.
    """

    def __init__(self, held: _core.Result):
        self._held = held

    def _matrix(self, parts: Any) -> Optional[csr_array]:
        if parts is None:
            return None
        count = len(parts[2]) - 1
        return csr_array(parts, shape=(count, count), copy=False)

    @cached_property
    def form_factors(self) -> csr_array:
        """F, n x n float64: F_ij is the share of the radiation leaving i that reaches j directly."""
        return self._matrix(self._held.sparse("form_factors"))

    @cached_property
    def standard_errors(self) -> csr_array:
        """Standard errors of F, in the same places."""
        return self._matrix(self._held.sparse("standard_errors"))

    @cached_property
    def exchange_areas(self) -> csr_array:
        """A_i F_ij, input units squared; symmetric to the last bit where both rows were requested."""
        return self._matrix(self._held.exchange_areas())

    @cached_property
    def balanced(self) -> Optional[csr_array]:
        """The nearest form factors whose rows sum to 1 (balance=True), or None."""
        return self._matrix(self._held.balanced())

    @cached_property
    def bounds(self) -> Optional[tuple[csr_array, csr_array]]:
        """The matrices (lower, upper) of a guarantee, or None. Where a pair has no entry, its form factor from the
        smaller row is at most `unlisted_bound`."""
        lower = self._matrix(self._held.sparse("lower"))
        return None if lower is None else (lower, self._matrix(self._held.sparse("upper")))

    @property
    def unlisted_bound(self) -> float:
        """The bound of a guarantee on form factors of pairs without an entry."""
        return self._held.unlisted_bound

    @cached_property
    def names(self) -> list[str]:
        """Name of each row: a surface, or "desk[3]"."""
        return self._held.names()

    @cached_property
    def areas(self) -> Floats:
        """Emitting area of each row, n float64, input units squared; both sides of two-sided polygons; 0 if empty."""
        return self._held.areas()

    @cached_property
    def environment(self) -> Floats:
        """F from each row out of the scene, n float64."""
        return self._held.environment()[0]

    @cached_property
    def environment_standard_errors(self) -> Floats:
        """Standard errors of `environment`, n float64."""
        return self._held.environment()[1]

    @cached_property
    def environment_bounds(self) -> Optional[tuple[Floats, Floats]]:
        """(lower, upper) of `environment`, n float64 each, of a guarantee; else None."""
        return self._held.environment_bounds()

    @cached_property
    def leak(self) -> Floats:
        """F from each row onto backs of polygons, n float64; above 0 where polygons are flipped or solids open."""
        return self._held.leak()[0]

    @cached_property
    def leak_standard_errors(self) -> Floats:
        """Standard errors of `leak`, n float64."""
        return self._held.leak()[1]

    @cached_property
    def leak_bounds(self) -> Optional[tuple[Floats, Floats]]:
        """(lower, upper) of `leak`, n float64 each, of a guarantee; else None."""
        return self._held.leak_bounds()

    @cached_property
    def row_sums(self) -> Floats:
        """Sum of each row as counted, environment and leak included, n float64; 0 for rows that were not requested."""
        return self._held.row_sums()

    @cached_property
    def closure(self) -> Optional[Closure]:
        """Distance of row sums from 1; None where the question leaves out some of the radiation from its rows."""
        found = self._held.closure()
        return None if found is None else Closure(*found)

    @cached_property
    def parameters(self) -> dict[str, Union[int, float, str]]:
        """Settings of the run by name, and the amount counted: seed, replicates, all_directions, all_lines and so on."""
        return {name: _number(value) for name, value in self._held.parameters}

    @property
    def warnings(self) -> list[str]:
        """Warnings of the run, a line each."""
        return self._held.warnings

    @property
    def seconds(self) -> float:
        """Time of the run, s; 0 for a result from a file."""
        return self._held.seconds

    def __len__(self) -> int:
        return len(self.names)

    def to_frame(self) -> Any:
        """Returns a pandas.DataFrame of the nonzero entries, with the columns of a .csv: from, to, form_factor,
        standard_error, and with a guarantee lower and upper. After the pairs, `to` is `environment` and `leak`."""
        import pandas

        pairs, errors = self.form_factors.tocoo(), self.standard_errors
        names = numpy.array(self.names, dtype=object)
        columns = {
            "from": names[pairs.row],
            "to": names[pairs.col],
            "form_factor": pairs.data,
            "standard_error": errors.data,
        }
        if self.bounds is not None:
            columns["lower"], columns["upper"] = self.bounds[0].data, self.bounds[1].data
        frames = [pandas.DataFrame(columns)]
        for to, values, of_values, bounds in (
            ("environment", self.environment, self.environment_standard_errors, self.environment_bounds),
            ("leak", self.leak, self.leak_standard_errors, self.leak_bounds),
        ):
            seen = numpy.flatnonzero(values)
            columns = {"from": names[seen], "to": to, "form_factor": values[seen], "standard_error": of_values[seen]}
            if bounds is not None:
                columns["lower"], columns["upper"] = bounds[0][seen], bounds[1][seen]
            frames.append(pandas.DataFrame(columns))
        return pandas.concat(frames, ignore_index=True)

    def save(self, file: Union[str, "os.PathLike[str]"], show: Sequence[str] = ()) -> None:
        """Writes a file by its extension: .csv, .mtx, .npz, .h5, .vtp, .html or .vwf (docs/formats.md). The file is
        never half written.

        In: show: names of surfaces or polygons; a .vtp gets an array with the form factors from each
        Raises: ValueError for an unknown extension or name, and for a .vtp of a result from a file; OSError
        """
        self._held.save(os.fspath(file), list(show))

    def report(self, file: Union[str, "os.PathLike[str]"]) -> None:
        """Writes a page for a browser without a network: the scene in colours, tables and charts.

        In: file: a name that ends in .html. The page of a result from a file has no scene; `viewpeel report` makes a
        page with a scene from a .h5
        Raises: ValueError for another name, or where viewpeel was built without the page; OSError
        """
        if not os.fspath(file).endswith(".html"):
            raise ValueError(f"{os.fspath(file)}: a page needs a name that ends in .html")
        self.save(file)

    def __reduce__(self) -> tuple[Callable[[bytes], Result], tuple[bytes]]:
        """Lets pickle, copy and multiprocessing take a result, as its .h5. As with load(), the copy has no scene, and its
        numbers may differ in the last digit."""
        with tempfile.TemporaryDirectory() as folder:
            file = os.path.join(folder, "result.h5")
            self.save(file)
            with open(file, "rb") as opened:
                return _from_bytes, (opened.read(),)

    def plot(self) -> Any:
        """Returns a matplotlib.figure.Figure: the matrix F_ij in logarithmic colours, and a histogram of errors."""
        from ._plot import plot

        return plot(self)

    def _largest(self, count: int = 10) -> list[tuple[str, str, float, float]]:
        pairs = self.form_factors.tocoo()
        places = numpy.argsort(-pairs.data, kind="stable")[:count]
        errors = self.standard_errors.data
        return [(self.names[pairs.row[k]], self.names[pairs.col[k]], pairs.data[k], errors[k]) for k in places]

    def _describe(self) -> str:
        errors = self.standard_errors.data
        largest = f", standard errors up to {errors.max():.1e}" if errors.size else ""
        return f"viewpeel.Result: {len(self)} rows, {self.form_factors.nnz} form factors{largest}"

    def __repr__(self) -> str:
        return f"<{self._describe()}>"

    def _repr_html_(self) -> str:
        lines = "".join(
            f"<tr><td>{html.escape(of)}</td><td>{html.escape(to)}</td><td>{f:.6f}</td><td>{error:.1e}</td></tr>"
            for of, to, f, error in self._largest()
        )
        head = "<tr><th>from</th><th>to</th><th>form factor</th><th>standard error</th></tr>"
        return f"<div>{html.escape(self._describe())}</div><table>{head}{lines}</table>"


def _from_bytes(content: bytes) -> Result:
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "result.h5")
        with open(file, "wb") as opened:
            opened.write(content)
        return load(file)


def load(file: Union[str, "os.PathLike[str]"]) -> Result:
    """Reads a .h5 that save() or `viewpeel compute -o` wrote.

    Out: Result; exchange areas are computed from the stored F_ij, so numbers may differ in the last digit
    Raises: ValueError where the file is no .h5 of results, cut off or damaged
    """
    return Result(_core.load(os.fspath(file)))
