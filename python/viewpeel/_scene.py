"""scene_of() makes scenes of files, arrays, and meshes of meshio, trimesh, pyvista and VTK."""

from __future__ import annotations

import math
import os
import warnings
from typing import Any, Optional, Sequence

import numpy

from . import _core

_UNITS_M = {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "in": 0.0254, "ft": 0.3048}
_MESHIO_CORNERS = {"triangle": 3, "triangle6": 3, "quad": 4, "quad8": 4, "quad9": 4}


def _indices(values: Any) -> Any:
    """Returns values as int64, in place where they are int64; raises ValueError where one is not a whole number."""
    given = numpy.asarray(values)
    try:
        with numpy.errstate(invalid="ignore"):
            whole = numpy.ascontiguousarray(given, dtype=numpy.int64)
    except (OverflowError, TypeError, ValueError):
        raise ValueError("polygons: not sequences of whole numbers, the indices of points") from None
    if given.dtype.kind != "i" and not numpy.array_equal(whole, given):
        raise ValueError("polygons: an index of a point is not a whole number; correct it")
    return whole


class Polygons:
    """Holds m polygons as flat arrays. points: n x 3 float64; corners: indices of points, int64; starts: m + 1 int64, so
    that polygon k has corners[starts[k]:starts[k + 1]]; surfaces: m indices of surface_names, int64.
    """

    def __init__(self, points: Any, corners: Any, starts: Any, names: Optional[Sequence[str]], title: str):
        if numpy.iscomplexobj(points):
            raise ValueError("points: are complex numbers; give their real coordinates")
        self.points = numpy.ascontiguousarray(points, dtype=numpy.float64)
        if self.points.ndim == 2 and self.points.shape[1] == 2:
            raise ValueError("points: have two coordinates, not three; add a column for z")
        self.corners = _indices(corners)
        self.starts = numpy.ascontiguousarray(starts, dtype=numpy.int64)
        self.title = title
        count = len(self.starts) - 1
        if names is None:
            self.surface_names, self.surfaces = [title], numpy.zeros(count, dtype=numpy.int64)
            return
        if isinstance(names, str) or len(names) != count:
            raise ValueError(f"names: {len(names)} for {count} polygons; give the surface of each polygon")
        places: dict[str, int] = {}
        of_polygons = [places.setdefault(str(name), len(places)) for name in names]
        self.surface_names, self.surfaces = list(places), numpy.array(of_polygons, dtype=numpy.int64)


def _flatten(polygons: Any) -> tuple[Any, Any]:
    """Returns corners and starts, as Polygons has them, of an n x k array or of sequences of any lengths."""
    if isinstance(polygons, numpy.ndarray) and polygons.ndim == 2:
        count, corner_count = polygons.shape
        return polygons.reshape(-1), numpy.arange(count + 1) * corner_count
    try:
        parts = [_indices(polygon) for polygon in polygons]
    except TypeError:
        raise ValueError("polygons: not sequences of whole numbers, the indices of points") from None
    lengths = [len(part) for part in parts]
    return numpy.concatenate(parts) if parts else [], numpy.concatenate([[0], numpy.cumsum(lengths)]).astype(int)


def _from_arrays(scene: Sequence[Any]) -> Polygons:
    points, polygons = scene[0], scene[1]
    corners, starts = _flatten(polygons)
    return Polygons(points, corners, starts, scene[2] if len(scene) == 3 else None, "polygons")


def _from_meshio(mesh: Any) -> Polygons:
    """Makes polygons of a mesh's triangles and quadrilaterals. Surfaces are its cell sets, else its physical groups;
    without either all polygons are one surface.
    """
    tags = {int(value[0]): name for name, value in (mesh.field_data or {}).items()}
    physical = mesh.cell_data.get("gmsh:physical")
    parts, starts, names = [], [0], []
    for block_index, block in enumerate(mesh.cells):
        corner_count = _MESHIO_CORNERS.get(block.type)
        if corner_count is None:
            continue
        block_names = ["polygons"] * len(block.data)
        if physical is not None:
            block_names = [tags.get(int(tag), f"group {int(tag)}") for tag in physical[block_index]]
        for set_name, members in mesh.cell_sets.items():
            for member in members[block_index] if members[block_index] is not None else []:
                block_names[int(member)] = set_name
        parts.append(numpy.asarray(block.data)[:, :corner_count].reshape(-1))
        starts.extend((starts[-1] + corner_count * numpy.arange(1, len(block.data) + 1)).tolist())
        names.extend(block_names)
    if not parts:
        raise ValueError("mesh: has no triangles or quadrilaterals; extract its surface first")
    return Polygons(mesh.points, numpy.concatenate(parts), starts, names, "mesh")


def _from_trimesh(mesh: Any) -> Polygons:
    """Makes polygons of trimesh: a Trimesh is one surface, and a Scene has one for each node."""
    if hasattr(mesh, "geometry") and hasattr(mesh, "graph"):
        points, faces, names, passed = [], [], [], 0
        for node in mesh.graph.nodes_geometry:
            transform, geometry_name = mesh.graph[node]
            part = mesh.geometry[geometry_name]
            points.append(numpy.asarray(part.vertices) @ transform[:3, :3].T + transform[:3, 3])
            faces.append(numpy.asarray(part.faces) + passed)
            names.extend([str(node)] * len(part.faces))
            passed += len(part.vertices)
        if not points:
            raise ValueError("mesh: the scene is empty")
        return Polygons(numpy.concatenate(points), *_flatten(numpy.concatenate(faces)), names, "mesh")
    return Polygons(mesh.vertices, *_flatten(numpy.asarray(mesh.faces)), None, "mesh")


def _from_vtk(mesh: Any) -> Polygons:
    """Makes polygons of pyvista.PolyData and vtkPolyData. Surfaces are named by a cell array of texts called surface,
    group or name.
    """
    from vtkmodules.util.numpy_support import vtk_to_numpy

    if mesh.GetNumberOfStrips() or mesh.GetNumberOfPolys() != mesh.GetNumberOfCells():
        raise ValueError("mesh: has cells that are no polygons; extract its surface first (extract_surface)")
    polygons, names = mesh.GetPolys(), None
    for name in ("surface", "group", "name"):
        array = mesh.GetCellData().GetAbstractArray(name)
        if array is not None and names is None:
            names = [array.GetVariantValue(k).ToString() for k in range(array.GetNumberOfTuples())]
    points = vtk_to_numpy(mesh.GetPoints().GetData())
    corners, starts = vtk_to_numpy(polygons.GetConnectivityArray()), vtk_to_numpy(polygons.GetOffsetsArray())
    return Polygons(points, corners, starts, names, "mesh")


def _polygons_of(scene: Any) -> Polygons:
    if isinstance(scene, (tuple, list)) and len(scene) in (2, 3):
        return _from_arrays(scene)
    if hasattr(scene, "GetPolys"):
        return _from_vtk(scene)
    if hasattr(scene, "cells") and hasattr(scene, "points") and hasattr(scene, "cell_sets"):
        return _from_meshio(scene)
    if (hasattr(scene, "vertices") and hasattr(scene, "faces")) or hasattr(scene, "geometry"):
        return _from_trimesh(scene)
    if hasattr(scene, "extract_surface"):
        raise ValueError("mesh: is no surface; give mesh.extract_surface()")
    raise ValueError(
        f"scene: {type(scene).__name__} is no scene; give a file, several files, (points, polygons, names), or a mesh of meshio, "
        "trimesh, pyvista or VTK"
    )


def _files_of(scene: Any) -> list[str]:
    """Returns the names of the files where the scene is one file or several, else an empty list."""
    files = [scene] if isinstance(scene, (str, os.PathLike)) else scene
    if not isinstance(files, (tuple, list)) or not all(isinstance(file, (str, os.PathLike)) for file in files):
        return []
    return [os.fspath(file) for file in files]


def scene_of(scene: Any, options: dict[str, Any]) -> _core.Scene:
    """Makes a scene, and warns of what was noticed in it.

    In: scene: file, files, arrays or mesh; options: takes sheets, solids, flip, fix_normals, units, zones, outside and lod out of it
    """
    if isinstance(scene, _core.Scene):
        return scene
    words = {name: [of] if isinstance(of := options.pop(name, ()), str) else list(of) for name in ("sheets", "solids", "flip")}
    units = options.pop("units", "m")
    if units not in _UNITS_M:
        raise ValueError(f"units: '{units}' is not one of {', '.join(_UNITS_M)}")
    how = dict(words, fix_normals=bool(options.pop("fix_normals", False)), unit_m=_UNITS_M[units])
    zones, outside = options.pop("zones", ()), bool(options.pop("outside", False))
    lod = options.pop("lod", None)
    if files := _files_of(scene):
        zones = [zones] if isinstance(zones, str) else list(zones)
        made = _core.load_scene(files, zones=zones, outside=outside, lod=math.inf if lod is None else float(lod), **how)
    elif zones or outside:
        raise ValueError("zones, outside: are of an EnergyPlus building; give its file, .idf or .epJSON")
    elif lod is not None:
        raise ValueError("lod: is of a city model; give its file, .json or .jsonl")
    else:
        polygons = _polygons_of(scene)
        made = _core.build_scene(
            polygons.points,
            polygons.corners,
            polygons.starts,
            polygons.surfaces,
            polygons.surface_names,
            polygons.title,
            **how,
        )
    for line in made.warnings:
        warnings.warn(line, stacklevel=4)
    return made
