"""Computes heat flows and temperatures of surfaces, from form factors or without them."""

from __future__ import annotations

import os
import re
import warnings
from typing import Any, Mapping, Optional, Sequence, Union

from . import _core
from ._compute import compute
from ._result import Result
from ._running import run_to_end
from ._scene import scene_of

_QUANTITIES = ("temperature", "radiosity", "irradiation", "heat_flux", "heat_flow")
_OF_REQUEST = {"by", "seconds", "two_sided", "seed", "engine", "device", "threads", "unoccluded", "pair_lines"}
_OF_MATRIX_FREE = {"by", "seconds", "two_sided", "seed", "threads"}
_OF_MATERIAL = {"emissivity", "temperature", "heat_flux", "directional"}


class Heat:
    """The answers of an enclosure, as arrays of n float64, one number a row: temperature (K), radiosity, irradiation,
    heat_flux (W/m2) and heat_flow (W if the unit of length is the metre). NAME_standard_errors are the errors that
    follow from the form factors' errors. NAME_bounds are bounds on the errors, which hold together with the probability
    of the form factors' guarantee; None without a guarantee. name, area and emissivity describe the rows.

    With by_surface=False rows are the rows of the form factors, with True they are sums and means over surfaces.
    """

    def __init__(self, held: _core.Heat, by_surface: bool):
        self._held, self._by_surface = held, by_surface
        columns = held.columns(by_surface)
        self.name, self.area, self.emissivity = columns["name"], columns["area"], columns["emissivity"]
        self.temperature, self.temperature_standard_errors, self.temperature_bounds = columns["temperature"]
        self.radiosity, self.radiosity_standard_errors, self.radiosity_bounds = columns["radiosity"]
        self.irradiation, self.irradiation_standard_errors, self.irradiation_bounds = columns["irradiation"]
        self.heat_flux, self.heat_flux_standard_errors, self.heat_flux_bounds = columns["heat_flux"]
        self.heat_flow, self.heat_flow_standard_errors, self.heat_flow_bounds = columns["heat_flow"]

    @property
    def form_factors(self) -> Result:
        """The form factors from which the answers were computed.    Raises: ValueError with matrix_free=True"""
        if self._held.form_factors is None:
            raise ValueError("matrix_free: no form factors were kept")
        return Result(self._held.form_factors)

    @property
    def to_environment(self) -> tuple[float, float]:
        """Heat flow out of the scene and its standard error; 0 for closed scenes."""
        return self._held.to_environment

    @property
    def balance_residual(self) -> float:
        """The sum of all heat flows less the heat flow to the environment: 0 but for rounding."""
        return self._held.balance_residual

    def by_surface(self) -> "Heat":
        """Returns the same answers, summed or averaged over each surface."""
        return Heat(self._held, True)

    def to_frame(self) -> Any:
        """Returns a pandas.DataFrame with the columns of a .csv."""
        import pandas

        columns = {"name": self.name, "area": self.area, "emissivity": self.emissivity}
        for quantity in _QUANTITIES:
            columns[quantity] = getattr(self, quantity)
            columns[f"{quantity}_standard_error"] = getattr(self, f"{quantity}_standard_errors")
            if getattr(self, f"{quantity}_bounds") is not None:
                columns[f"{quantity}_bound"] = getattr(self, f"{quantity}_bounds")
        return pandas.DataFrame(columns)

    def save(self, file: Union[str, "os.PathLike[str]"]) -> None:
        """Writes a .csv, as `viewpeel solve -o` does.    Raises: ValueError for another extension; OSError"""
        self._held.save(os.fspath(file), self._by_surface)

    def __len__(self) -> int:
        return len(self.name)


def _numbers_of(given: Any) -> list[float]:
    """Makes a list of one number or several."""
    try:
        return [float(given)]
    except TypeError:
        return [float(value) for value in given]


def _law_of(name: str, directional: Any) -> tuple[float, list[float], list[float]]:
    """Makes a directional law: (cosine power, angles, values)."""
    try:
        if isinstance(directional, str) or not hasattr(directional, "__iter__"):
            power = float(directional)
            if not 0 <= power < float("inf"):
                raise ValueError
            return power, [], []
        pairs = [(float(angle), float(value)) for angle, value in directional]
    except (TypeError, ValueError):
        raise ValueError(
            f"materials: {name}: directional is a power of the cosine from 0 on, or pairs of an angle in degrees and a "
            "value"
        ) from None
    return 0.0, [angle for angle, _ in pairs], [value for _, value in pairs]


def _materials_of(materials: Any, environment: Optional[float], bands: Optional[Sequence[float]]) -> _core.Materials:
    if isinstance(materials, (str, os.PathLike)):
        for argument, value in (("environment", environment), ("bands", bands)):
            if value is not None:
                raise ValueError(f"{argument}: stands in the file of materials; leave out the argument")
        return _core.read_materials(os.fspath(materials))
    limits = [float(limit) for limit in bands or ()]
    if any(not 0 < limit < float("inf") for limit in limits) or sorted(set(limits)) != limits:
        raise ValueError(f"bands: {limits} are not ascending wavelengths in micrometres")
    lines, laws = [], []
    for name, material in materials.items():
        unknown = set(material) - _OF_MATERIAL
        given = material.get("emissivity", 1.0)
        emissivities = _numbers_of(given)
        temperature, heat_flux = material.get("temperature"), material.get("heat_flux")
        if unknown:
            raise ValueError(f"materials: {name}: no '{sorted(unknown)[0]}'; there is {', '.join(sorted(_OF_MATERIAL))}")
        if len(emissivities) == 1:
            emissivities *= len(limits) + 1
        if len(emissivities) != len(limits) + 1:
            raise ValueError(f"materials: {name}: {len(emissivities)} emissivities for {len(limits) + 1} bands")
        for emissivity in emissivities:
            if not 0 < emissivity <= 1:
                raise ValueError(f"materials: {name}: emissivity {emissivity} is not above 0 and at most 1")
        if (temperature is None) == (heat_flux is None):
            raise ValueError(f"materials: {name}: give one of temperature and heat_flux (0: adiabatic)")
        if temperature is not None and not 0 <= temperature < float("inf"):
            raise ValueError(f"materials: {name}: temperature {temperature} is not a number of K from 0 on")
        if heat_flux is not None and not abs(heat_flux) < float("inf"):
            raise ValueError(f"materials: {name}: heat_flux {heat_flux} is not a number of W/m2")
        law = None
        if material.get("directional") is not None:
            if limits:
                raise ValueError(f"materials: {name}: directional beside bands; leave one of the two out")
            law = len(laws)
            laws.append(_law_of(name, material["directional"]))
        lines.append((str(name), emissivities, temperature, heat_flux, law))
    if environment is not None and not 0 <= environment < float("inf"):
        raise ValueError(f"environment: {environment} is not a temperature in K from 0 on")
    return _core.Materials(lines, environment, limits, laws)


def _tolerance_of(tolerance: str) -> tuple[float, str]:
    """Reads a tolerance of the answers: (value, unit)."""
    match = re.fullmatch(r"\s*([0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(K|W/m2|%)\s*", tolerance)
    if not match or not float(match[1]) > 0:
        raise ValueError(f"tolerance: '{tolerance}' is not a number above 0 with a unit: 0.1K, 2W/m2 or 1%")
    return (float(match[1]) / 100 if match[2] == "%" else float(match[1])), match[2]


def _arguments_of(options: dict[str, Any], names: set[str]) -> dict[str, Any]:
    return {name: options.pop(name) for name in list(options) if name in names}


def _solve_scene(scene: Any, table: _core.Materials, matrix_free: Optional[bool], options: dict[str, Any]) -> Heat:
    made = scene_of(scene, options)
    by_surface = options["by"] == "surface"
    if matrix_free is None:
        takes_form_factors = not set(options) <= _OF_MATRIX_FREE | {"tolerance", "progress"} or isinstance(
            options.get("tolerance"), (int, float)
        )
        is_large = _core.is_matrix_free(made, table, by_surface)
        matrix_free = table.is_directional or (is_large and not takes_form_factors)
    if matrix_free:
        return Heat(_solve_without_matrix(made, table, options), by_surface)
    if isinstance(options.get("tolerance"), str):
        return Heat(_solve_to(made, table, options.pop("tolerance"), options), by_surface)
    if options.get("epsilon") is not None:
        options.setdefault("pair_lines", True)  # pair lines give an interval for each pair
    else:
        options.setdefault("promise", False)  # estimates have standard errors, which the answers' errors follow from
    options.setdefault("lines_for_all", True)
    return Heat(_core.solve(compute(made, **options)._held, table), by_surface)


def _solve_to(made: _core.Scene, table: _core.Materials, tolerance: str, options: dict[str, Any]) -> _core.Heat:
    value, unit = _tolerance_of(tolerance)
    for name in ("relative", "rms", "epsilon", "directions", "replicates", "checkpoint", "resume"):
        if options.pop(name, None):
            raise ValueError(f"{name}: form factors are computed to the tolerance of the answers; leave it out")
    progress = options.pop("progress", False)
    arguments = _arguments_of(options, _OF_REQUEST)
    if options:
        raise TypeError(f"solve() has no argument {', '.join(map(repr, options))}")
    held, is_reached = run_to_end(
        lambda tick: _core.solve_to(made, arguments, table, value, unit, tick), progress
    )
    return _reached(held, is_reached, tolerance)


def _solve_without_matrix(made: _core.Scene, table: _core.Materials, options: dict[str, Any]) -> _core.Heat:
    tolerance = options.pop("tolerance", None)
    progress = options.pop("progress", False)
    arguments = _arguments_of(options, _OF_MATRIX_FREE)
    for name in sorted(options):
        raise ValueError(f"{name}: no form factors are kept; leave it out, or say matrix_free=False")
    if tolerance is not None and not isinstance(tolerance, str):
        raise ValueError(f"tolerance: {tolerance} is of form factors, of which none are kept; give one of answers: '1%'")
    goal = None if tolerance is None else _tolerance_of(tolerance)
    held, is_reached = run_to_end(
        lambda tick: _core.solve_without_matrix(made, arguments, table, goal, tick), progress
    )
    return _reached(held, is_reached, tolerance or "1% of the heat, or 1K")


def _reached(heat: _core.Heat, is_reached: bool, tolerance: str) -> _core.Heat:
    if not is_reached:
        warnings.warn(f"time was up before the tolerance of {tolerance}; give more seconds", stacklevel=5)
    return heat


def solve(
    scene: Any,
    materials: Union[str, "os.PathLike[str]", Mapping[str, Mapping[str, Any]]],
    *,
    environment: Optional[float] = None,
    bands: Optional[Sequence[float]] = None,
    matrix_free: Optional[bool] = None,
    **options: Any,
) -> Heat:
    """Solves B_i = e_i s T_i^4 + (1 - e_i) H_i, A_i H_i = sum_j A_i F_ij B_j (docs/solve.md).

    In:
        scene: a Result of all rows, or whatever compute() takes
        materials: a .csv file of materials, or {name: {"emissivity": 0..1, and either "temperature": K or "heat_flux":
            W/m2}}; a name is a surface or polygon, with wildcards * and ?, or "default". "directional" says how
            emissivity depends on the angle: a power of the cosine, or pairs (angle in degrees, relative emissivity)
        environment: temperature of the surroundings, K; needed for open scenes
        bands: wavelengths in micrometres at which bands meet. "emissivity" is then a sequence, one number for each band
        matrix_free: True keeps no form factors, for scenes of any size; False keeps them. By default none are kept where
            emissivity depends on the angle, or where they could take more than 4 GiB
        options: options of compute(), if scene is no Result; `by` is "surface" by default. With epsilon all answers
            have bounds. tolerance may also be a text, the largest standard error of the answers: "0.1K" of
            temperatures, "2W/m2" of heat fluxes, "1%" of heat flows over all heat. Then form factors are computed
            until the answers are that exact, or the time limit `seconds` is up, with a warning
    Out: Heat
    Error: standard errors of first order; of the equations 1e-11 of the largest radiosity
    Raises: ValueError with the program's line; Error; as compute()
    """
    table = _materials_of(materials, environment, bands)
    if isinstance(scene, Result):
        if options:
            raise TypeError("solve() computes nothing of a Result: leave out the options of compute()")
        if matrix_free:
            raise ValueError("matrix_free: a Result has its form factors; give the scene")
        return Heat(_core.solve(scene._held, table), scene.parameters.get("by") == "surface")
    return _solve_scene(scene, table, matrix_free, {"by": "surface", **options})
