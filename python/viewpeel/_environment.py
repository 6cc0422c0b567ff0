"""Measures the share of each row's radiation that leaves the scene, without form factors between rows."""

from __future__ import annotations

import warnings
from typing import Any, Callable, Optional, Sequence, Union

import numpy
from numpy.typing import NDArray

from . import _core
from ._running import Progress, run_to_end
from ._scene import scene_of

Floats = NDArray[numpy.float64]


class Environment:
    """Holds form factors from n rows out of the scene. `environment` is the whole, `up` and `down` its parts above and
    below the horizon: n float64 each, without unit, beside NAME_standard_errors. Rows are in the order of the scene;
    empty rows have 0. names and areas (input units squared) say which row it is, replicates and directions how much was
    counted, and is_reached whether the tolerance was reached.
    """

    def __init__(self, columns: dict[str, Any]):
        self.names: list[str] = columns["names"]
        self.areas: Floats = columns["areas"]
        self.environment, self.environment_standard_errors = columns["environment"]
        self.up, self.up_standard_errors = columns["up"]
        self.down, self.down_standard_errors = columns["down"]
        self.replicates: int = columns["replicates"]
        self.directions: int = columns["directions"]
        self.is_reached: bool = columns["is_reached"]

    def __len__(self) -> int:
        return len(self.names)

    def __repr__(self) -> str:
        return f"<viewpeel.Environment of {len(self)} rows, {self.directions} directions>"

    def to_frame(self) -> Any:
        """Returns a pandas.DataFrame with a line for each row, as in .rows.csv."""
        import pandas

        columns: dict[str, Any] = {"name": self.names, "area": self.areas}
        for name, of_frame in (("environment", "environment"), ("up", "environment_up"), ("down", "environment_down")):
            columns[of_frame] = getattr(self, name)
            columns[of_frame + "_standard_error"] = getattr(self, name + "_standard_errors")
        return pandas.DataFrame(columns)


def environment(
    scene: Any,
    *,
    tolerance: float = 1e-3,
    seconds: Optional[float] = None,
    by: str = "polygon",
    up: Sequence[float] = (0, 0, 1),
    two_sided: bool = False,
    seed: int = 1,
    threads: int = 0,
    progress: Union[bool, Callable[[Progress], None]] = False,
    **scene_options: Any,
) -> Environment:
    """Computes F_i,up = (2 / A_i) E[A'_i,up(u)], the same downwards, and both together, as `viewpeel compute --only
    environment --up X,Y,Z` does.

    In:
        scene: as of compute()
        tolerance: largest standard error of the form factors to either part and to both, above 0
        seconds: time limit, s: stop short of the tolerance, with a warning
        by: rows are "polygon" or "surface"
        up: the direction above the horizon, of any length above 0
        two_sided, seed, threads, progress, scene_options: as of compute()
    Out: Environment of the scene's rows
    Error: standard errors of 8 replicates
    Raises: as compute(); Interrupted on Ctrl-C, without a result
    Cost: as many directions as the tolerance takes, up to 2^19
    """
    if by not in ("polygon", "surface"):
        raise ValueError(f"by: '{by}' is not one of polygon, surface")
    direction = [float(x) for x in up]
    if len(direction) != 3:
        raise ValueError("up: is not three numbers; give one like (0, 0, 1)")
    made = scene_of(scene, scene_options)
    if scene_options:
        raise TypeError(f"environment() has no argument {', '.join(map(repr, scene_options))}")
    columns = run_to_end(
        lambda tick: _core.measure_environment(
            made, by == "surface", two_sided, direction, tolerance, seconds, seed, threads, tick
        ),
        progress,
    )
    found = Environment(columns)
    if not found.is_reached:
        warnings.warn(f"time was up before the tolerance of {tolerance}; give more seconds", stacklevel=2)
    return found
