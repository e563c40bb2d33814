"""What this machine has: libraries, linear solvers, OpenGL, threads, the folder of compiled kernels."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping
from importlib.util import find_spec
from typing import Any

from knotfem.errors import MissingDependency
from knotfem.run.provenance import library_versions
from knotfem.scene.control import Solver
from knotfem.threads import VARIABLES, usable_threads


def describe() -> dict[str, Any]:
    """Facts by topic, each a table of names and values that JSON holds."""
    from knotfem.sparse.linear import available

    solvers = available()
    return {
        "versions": library_versions(),
        "machine": {"platform": platform.platform(), "processor": platform.machine(), "memory_gb": _memory()},
        "linear solvers": {
            "pardiso": "works" if "pardiso" in solvers else "missing; cure: pip install mkl (x86-64 only)",
            "superlu": "works (SciPy)",
            "auto takes": solvers[0],
        },
        "threads": {"processors": os.cpu_count(), "usable": usable_threads(), **_thread_settings()},
        "pictures": _pictures(),
        "compiled kernels": _kernels(),
    }


def require(solver: Solver) -> None:
    """Check that this machine has what a scene's solver asks for.

    Raises:
        MissingDependency: the linear solver is missing; names the cure.
    """
    from knotfem.sparse.linear import available

    if solver.linear not in ("auto", *available()):
        raise MissingDependency(f"the linear solver {solver.linear} is missing; cure: pip install mkl (x86-64 only)")


def _thread_settings() -> Mapping[str, str]:
    return {name: os.environ[name] for name in VARIABLES if name in os.environ}


def _memory() -> float:
    import psutil

    return round(psutil.virtual_memory().total / 1e9, 1)


def _pictures() -> dict[str, str]:
    from knotfem.plot.opengl import CURE, find_window

    missing = [name for name in ("matplotlib", "pyvista", "gmsh", "meshio") if find_spec(name) is None]
    window = find_window() if "pyvista" not in missing else None
    return {
        "missing libraries": ", ".join(missing) or "none",
        "OpenGL off screen": f"works ({window})" if window else f"missing; cure: {CURE}",
        "display": os.environ.get("DISPLAY", "none"),
    }


def _kernels() -> dict[str, Any]:
    """The folder of compiled kernels; another than the wanted one, or none, where that cannot be written."""
    from knotfem.compiled import cache_folder, wanted_folder

    wanted, folder = wanted_folder(), cache_folder()
    found = {"folder": str(folder or wanted), "writable": folder is not None}
    return found if folder in (wanted, None) else {**found, "cannot be written": str(wanted)}
