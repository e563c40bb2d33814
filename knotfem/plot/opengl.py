"""Finds a way to draw without a screen, before VTK crashes for want of one."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

from knotfem.errors import MissingDependency

WINDOWS = {"vtkEGLRenderWindow": "EGL", "vtkOSOpenGLRenderWindow": "OSMesa", "vtkXOpenGLRenderWindow": "X"}
CURE = "apt-get install libegl1 libgl1-mesa-dri (or libosmesa6); dnf install mesa-libEGL mesa-dri-drivers"

_VARIABLE = "VTK_DEFAULT_OPENGL_WINDOW"
_DRAW = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderer, vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(True)
window.SetSize(16, 16)
window.AddRenderer(vtkRenderer())
window.Render()
print("drawn by", window.GetClassName())
"""


@cache
def find_window() -> str | None:
    """Name of the VTK render window that works here, or none.

    VTK loads OpenGL at run time and ends the process if it finds none, so each kind is tried in a process of its own:
    what the environment variable VTK_DEFAULT_OPENGL_WINDOW asks for, else EGL, OSMesa and, where there is a display, X.
    Away from Linux the system always has one, and VTK's own choice is taken.
    """
    if not sys.platform.startswith("linux"):
        return "default"
    asked = os.environ.get(_VARIABLE)
    candidates = [asked] if asked else [name for name in WINDOWS if WINDOWS[name] != "X" or os.environ.get("DISPLAY")]
    for name in candidates:
        try:
            tried = subprocess.run(
                [sys.executable, "-c", _DRAW],
                env={**os.environ, _VARIABLE: name},
                capture_output=True,
                text=True,
                timeout=120,
                check=False,
            )
        except subprocess.TimeoutExpired:
            continue
        if tried.returncode == 0 and f"drawn by {name}" in tried.stdout:
            return name
    return None


def prepare(*, off_screen: bool = True) -> None:
    """Make VTK draw off screen with the window that works, or see that there is one.

    Args:
        off_screen: without, the kind of window is left to VTK, which knows what can be seen.

    Raises:
        MissingDependency: pyvista is absent, or no OpenGL library works; names the packages that cure it.
    """
    try:
        import pyvista  # noqa: F401
    except ImportError as error:
        raise MissingDependency(f"pictures need pyvista ({error}): pip install pyvista") from error
    name = find_window()
    if name is None:
        raise MissingDependency(f"pictures need OpenGL, and neither EGL nor OSMesa works on this machine: {CURE}")
    if off_screen and name != "default":
        os.environ[_VARIABLE] = name
