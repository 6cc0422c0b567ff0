"""Runs show progress, and end by themselves or by Ctrl-C."""

from __future__ import annotations

from typing import Any, Callable, Dict, Optional, Tuple, TypeVar, Union

from . import _core
from ._result import Result

Progress = Dict[str, Union[int, float, str]]
Tick = Optional[Callable[[Progress], None]]
Answer = TypeVar("Answer")


class Interrupted(KeyboardInterrupt):
    """Ctrl-C stopped a run.

    result: the Result of the replicates counted so far, or None: with fewer than two, of environment(), and of solve()
        with a tolerance of its answers
    checkpoint: the file with the counts, from which resume=True continues; None where no file was given
    """

    def __init__(self, result: Optional[Result], checkpoint: Optional[str]):
        self.result, self.checkpoint = result, checkpoint
        kept = f"; {checkpoint} has what was counted, go on with resume=True" if checkpoint and result else ""
        super().__init__("stopped" + kept)


class _ProgressBar:
    """A bar of tqdm that counts replicates, after the name of the phase."""

    def __init__(self, kind: Any, total: Optional[int]):
        self._bar, self._total = kind(unit=" replicates", leave=False), total

    def __call__(self, progress: Progress) -> None:
        self._bar.total = progress["expected_blocks"] or self._total
        self._bar.n = progress["replicates"]
        self._bar.set_description_str(str(progress["phase"]), refresh=False)
        error = progress["largest_standard_error"]
        if error != float("inf"):
            self._bar.set_postfix_str(f"largest standard error {error:.1e}", refresh=False)
        self._bar.refresh()

    def close(self) -> None:
        self._bar.close()


def _progress_bar(total: Optional[int]) -> _ProgressBar:
    try:
        from tqdm.auto import tqdm
    except ImportError:
        raise ValueError("progress=True needs tqdm; install it, or give a function") from None
    return _ProgressBar(tqdm, total)


def run_to_end(
    run: Callable[[Tick], Tuple[Optional[Answer], Optional[BaseException]]],
    progress: Union[bool, Callable[[Progress], None]],
    checkpoint: Optional[str] = None,
    result_of: Callable[[Answer], Optional[Result]] = lambda answer: None,
    total: Optional[int] = None,
) -> Answer:
    """Calls a function of the compiled part, and closes the bar of tqdm at its end.

    In:
        run: gets a function to call with the progress, or None; returns its answer and the exception that stopped it
        progress: as of compute()
        checkpoint: the file of the run's counts
        result_of: makes the result of an answer for Interrupted
        total: the number of replicates, where it is known
    Out: the answer of a run that ended by itself
    Raises: Interrupted where Ctrl-C stopped the run; what `progress` raised; Error where there is no answer
    """
    bar = _progress_bar(total) if progress is True else None
    try:
        answer, stop = run(bar or (progress if callable(progress) else None))
    finally:
        if bar is not None:
            bar.close()
    if isinstance(stop, KeyboardInterrupt):
        raise Interrupted(None if answer is None else result_of(answer), checkpoint) from None
    if stop is not None:
        raise stop
    if answer is None:
        raise _core.Error("the run was stopped before it had a result")
    return answer
