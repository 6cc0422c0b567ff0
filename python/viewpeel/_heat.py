"""Heat flows and temperatures of grey, diffuse surfaces."""

from __future__ import annotations

import os
from typing import Any, Mapping, Optional, Union

from . import _core
from ._compute import compute
from ._result import Result

_QUANTITIES = ("temperature", "radiosity", "irradiation", "heat_flux", "heat_flow")
_OF_MATERIAL = {"emissivity", "temperature", "heat_flux"}


class Heat:
    """Answers of an enclosure. Each of temperature (K), radiosity, irradiation, heat_flux (W/m2) and heat_flow (W where
    the unit of length is the metre) is an n float64 array, one number a row; NAME_standard_errors has the errors that
    the form factors' errors cause. name, area and emissivity say which row it is.

    by_surface=False: rows are those of the form factors; True: sums and means over each surface.
    """

    def __init__(self, held: _core.Heat, by_surface: bool):
        self._held, self._by_surface = held, by_surface
        columns = held.columns(by_surface)
        self.name, self.area, self.emissivity = columns["name"], columns["area"], columns["emissivity"]
        self.temperature, self.temperature_standard_errors = columns["temperature"]
        self.radiosity, self.radiosity_standard_errors = columns["radiosity"]
        self.irradiation, self.irradiation_standard_errors = columns["irradiation"]
        self.heat_flux, self.heat_flux_standard_errors = columns["heat_flux"]
        self.heat_flow, self.heat_flow_standard_errors = columns["heat_flow"]

    @property
    def form_factors(self) -> Result:
        """The form factors that the answers come from."""
        return Result(self._held.form_factors)

    @property
    def to_environment(self) -> tuple[float, float]:
        """Heat flow out of the scene and its standard error; 0 for closed scenes."""
        return self._held.to_environment

    @property
    def balance_residual(self) -> float:
        """All heat flows less that to the environment: 0 but for rounding."""
        return self._held.balance_residual

    def by_surface(self) -> "Heat":
        """The same answers, summed and averaged over each surface."""
        return Heat(self._held, True)

    def to_frame(self) -> Any:
        """pandas.DataFrame with a line a row, as .csv has them."""
        import pandas

        columns = {"name": self.name, "area": self.area, "emissivity": self.emissivity}
        for quantity in _QUANTITIES:
            columns[quantity] = getattr(self, quantity)
            columns[f"{quantity}_standard_error"] = getattr(self, f"{quantity}_standard_errors")
        return pandas.DataFrame(columns)

    def save(self, file: Union[str, "os.PathLike[str]"]) -> None:
        """Writes a .csv, as `viewpeel solve -o` does.    Raises: ValueError for another extension; OSError"""
        self._held.save(os.fspath(file), self._by_surface)

    def __len__(self) -> int:
        return len(self.name)


def _materials_of(materials: Any, environment: Optional[float]) -> _core.Materials:
    if isinstance(materials, (str, os.PathLike)):
        if environment is not None:
            raise ValueError("environment: stands in the file of materials; leave out the argument")
        return _core.read_materials(os.fspath(materials))
    lines = []
    for name, material in materials.items():
        unknown = set(material) - _OF_MATERIAL
        emissivity = float(material.get("emissivity", 1.0))
        temperature, heat_flux = material.get("temperature"), material.get("heat_flux")
        if unknown:
            raise ValueError(f"materials: {name}: no '{sorted(unknown)[0]}'; there is {', '.join(sorted(_OF_MATERIAL))}")
        if not 0 < emissivity <= 1:
            raise ValueError(f"materials: {name}: emissivity {emissivity} is not above 0 and at most 1")
        if (temperature is None) == (heat_flux is None):
            raise ValueError(f"materials: {name}: give one of temperature and heat_flux (0: adiabatic)")
        if temperature is not None and not 0 <= temperature < float("inf"):
            raise ValueError(f"materials: {name}: temperature {temperature} is not a number of K from 0 on")
        if heat_flux is not None and not abs(heat_flux) < float("inf"):
            raise ValueError(f"materials: {name}: heat_flux {heat_flux} is not a number of W/m2")
        lines.append((str(name), emissivity, temperature, heat_flux))
    if environment is not None and not 0 <= environment < float("inf"):
        raise ValueError(f"environment: {environment} is not a temperature in K from 0 on")
    return _core.Materials(lines, environment)


def solve(
    scene: Any,
    materials: Union[str, "os.PathLike[str]", Mapping[str, Mapping[str, float]]],
    *,
    environment: Optional[float] = None,
    **options: Any,
) -> Heat:
    """Solves B_i = e_i s T_i^4 + (1 - e_i) H_i, A_i H_i = sum_j A_i F_ij B_j (docs/solve.md).

    In:
        scene: a Result of all rows, or whatever compute() takes
        materials: a .csv file of materials, or {name: {"emissivity": 0..1, and one of "temperature": K and
            "heat_flux": W/m2}}; names of surfaces or polygons, with wildcards * and ?, or "default"
        environment: temperature of what lies outside, K; needed for open scenes
        options: of compute(), where scene is no Result; by="surface" unless said otherwise
    Out: Heat
    Error: standard errors of first order; of the equations 1e-11 of the largest radiosity
    Raises: ValueError with the program's line; Error; as compute()
    """
    table = _materials_of(materials, environment)
    if isinstance(scene, Result):
        if options:
            raise TypeError("solve() computes nothing of a Result: leave out the options of compute()")
        return Heat(_core.solve(scene._held, table), False)
    return Heat(_core.solve(compute(scene, **{"by": "surface", **options})._held, table), False)
