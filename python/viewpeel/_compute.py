"""compute() computes form factors."""

from __future__ import annotations

import os
import warnings
from typing import Any, Callable, Dict, Optional, Sequence, Union

from . import _core
from ._result import Result
from ._running import Progress, run_to_end
from ._scene import scene_of

def _names(names: Union[str, Sequence[str]]) -> list[str]:
    return [names] if isinstance(names, str) else list(names)


def _check_checkpoint(checkpoint: Optional[str], resume: bool) -> None:
    if resume and checkpoint is None:
        raise ValueError("resume: goes on with a checkpoint; name its file")
    if checkpoint is not None and not resume and os.path.exists(checkpoint):
        raise ValueError(f"{checkpoint}: is there already; go on with it by resume=True, or name another file")


def compute(
    scene: Any,
    *,
    tolerance: Optional[float] = None,
    relative: Optional[float] = None,
    rms: Optional[float] = None,
    seconds: Optional[float] = None,
    epsilon: Optional[float] = None,
    delta: Optional[float] = None,
    rows: Optional[bool] = None,
    directions: Optional[int] = None,
    replicates: Optional[int] = None,
    resolution: Optional[int] = None,
    floor: Optional[float] = None,
    by: str = "polygon",
    rows_of: Union[str, Sequence[str]] = (),
    pair: Sequence[str] = (),
    blockers: Union[str, Sequence[str]] = (),
    two_sided: bool = False,
    balance: bool = False,
    seed: int = 1,
    engine: str = "auto",
    device: str = "",
    threads: int = 0,
    sampling: Optional[str] = None,
    sampler: Optional[str] = None,
    unoccluded: Optional[bool] = None,
    pair_lines: Optional[bool] = None,
    promise: Optional[bool] = None,
    lines_for_all: bool = False,
    checkpoint: Union[str, "os.PathLike[str]", None] = None,
    resume: bool = False,
    progress: Union[bool, Callable[[Progress], None]] = False,
    **scene_options: Any,
) -> Result:
    """Computes F_ij = (2 / A_i) E[A'_ij(u)] for all pairs, as `viewpeel compute` does with options of the same names.

    In:
        scene: one of these:
            a file (.obj, .stl, .ply, .gltf, .glb, .vs3, .inp, .msh, .vtp, .vtu, .json, .jsonl, .idf, .epJSON) or the
                folder of an OpenFOAM case,
            a list of files, each with a part of the scene (.obj, .stl, .ply, .gltf, .glb, .msh, .vtp, .vtu, .json,
                .jsonl),
            (points, polygons) or (points, polygons, names): n x 3 float64, in any unit of length; m sequences of
                indices from 0, counter-clockwise seen from the front, or an m x k array; the surface of each polygon,
            a mesh of meshio, trimesh, pyvista (PolyData) or VTK
        tolerance: largest error, above 0. It is the default goal, promised where a promise costs little more (see
            promise), else estimated
        relative: largest relative standard error, over form factors of at least `floor` (0.01)
        rms: largest root mean square of the errors of all n x n form factors, above 0; a goal of its own
        seconds: time limit, s; with another goal the run may stop before it
        epsilon, delta, rows: a guarantee: with probability 1 - delta (0.01) every form factor is within epsilon; with
            rows=True each row's environment is, too
        directions, replicates, resolution: fixed amounts, instead of a plan
        by: rows are "polygon" or "surface"
        rows_of, pair, blockers: names of surfaces or polygons ("desk[3]"): rows to compute; the one pair to compute;
            obstacles that neither emit nor receive
        two_sided: both sides emit and receive
        balance: computes also the nearest form factors whose rows sum to 1; for closed scenes
        seed: the same seed and plan give the same bits
        engine, device, threads, sampling, sampler, unoccluded, pair_lines: as the program's options
        promise: whether the tolerance is a guarantee, with an interval for each form factor (`bounds`). By default it
            is where a guarantee costs at most twice an estimate, or half a second of CPU time; never with a checkpoint
        lines_for_all: whether an estimate of up to 8,000 polygons has lines for all pairs, small ones too, which matter
            where form factors are added up, as solve() does; always with a checkpoint
        checkpoint, resume: a file for the counts, written at the end, on Ctrl-C and every half minute; whether to
            continue from it
        progress: True for tqdm's bar, or a function that is called some 20 times a second with a dict: phase
            ("planning", "unoccluded" or "counting"), replicates, largest_standard_error (infinite where the goal does
            not look at it), directions, directions_of_replicate, and of a guarantee expected_blocks and most_blocks.
            An exception that it raises stops the run and is passed on
        scene_options: sheets, solids, flip (names), fix_normals (bool), units ("m", "mm", "cm", "in", "ft"); of an
            EnergyPlus building zones (names) or outside (bool); of a city model lod (the highest level of detail)
    Out: Result of the scene's rows
    Error: as the goal demands; standard errors are estimates, and intervals of a guarantee are bounds
    Raises: ValueError with the program's line for bad scenes and options; Interrupted on Ctrl-C; OSError; Error;
        MemoryError
    Cost: as the program, plus less than 1 ms a call; other Python threads run meanwhile
    """
    arguments: Dict[str, Any] = dict(
        tolerance=tolerance, relative=relative, rms=rms, seconds=seconds, epsilon=epsilon, delta=delta, rows=rows,
        directions=directions, replicates=replicates, resolution=resolution, floor=floor, by=by,
        rows_of=_names(rows_of), pair=_names(pair), blockers=_names(blockers), two_sided=two_sided, balance=balance,
        seed=seed, engine=engine, device=device, threads=threads, sampling=sampling, sampler=sampler,
        unoccluded=unoccluded, pair_lines=pair_lines, promise=promise, lines_for_all=lines_for_all,
    )  # fmt: skip
    file = None if checkpoint is None else os.fspath(checkpoint)
    _check_checkpoint(file, resume)
    made = scene_of(scene, scene_options)
    if scene_options:
        raise TypeError(f"compute() has no argument {', '.join(map(repr, scene_options))}")
    held = run_to_end(
        lambda tick: _core.compute(made, arguments, file or "", resume, tick),
        progress,
        file,
        Result,
        replicates if directions else None,
    )
    result = Result(held)
    for line in result.warnings:
        warnings.warn(line, stacklevel=2)
    return result
