"""Form factors (view factors) of polygonal scenes with occlusion, with a stated error.

    import viewpeel
    result = viewpeel.compute("room.obj", by="surface", tolerance=1e-3)
    result.form_factors      # scipy.sparse.csr_array, F[i, j] from row i to row j
    result.standard_errors   # the same shape
    result.save("room.h5")

Errors of input or usage raise ValueError, with the line that the program prints. Files that cannot be written raise
OSError; devices and limits raise viewpeel.Error. docs/python.md of the project has more.
"""

from ._compute import compute
from ._core import Error, __version__
from ._environment import Environment, environment
from ._heat import Heat, solve
from ._result import Closure, Result, load
from ._running import Interrupted

__all__ = [
    "Closure", "Environment", "Error", "Heat", "Interrupted", "Result", "__version__",
    "compute", "environment", "load", "solve",
]  # fmt: skip
