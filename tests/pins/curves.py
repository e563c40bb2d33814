"""Curves of scenes, as the pins compare them: the one place of this folder that touches the program.

Whoever changes how a scene is run adapts these functions and nothing else here.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

import knotfem as kf

Curve = tuple[np.ndarray, np.ndarray]
"""Abscissa and ordinate, each of shape [points]."""


def force_curve(scene: str, overrides: Sequence[str] = ()) -> Curve:
    """Displacement [mm] and force [N] of the driven end at every accepted step of all pulls of a shipped scene.

    Where pulls follow each other, the displacement of the later one goes on from the end of the earlier one.

    Args:
        scene: a shipped name.
        overrides: of keys of the scene, such as "contact.friction=0.3".
    """
    return force_of(kf.pull(scene, overrides, progress=False))


def sag_curve(scene: str, overrides: Sequence[str] = ()) -> Curve:
    """Arclength [mm] and sag [mm] below the clamped start of a shipped scene's rod at the end; see `force_curve`."""
    return sag_of(kf.pull(scene, overrides, progress=False))


def force_of(run: kf.Run) -> Curve:
    """As `force_curve`, of a run that is there."""
    curve = run.force
    return curve.displacement, curve.force


def sag_of(run: kf.Run) -> Curve:
    """As `sag_curve`, of a run that is there."""
    profile = run.tension()
    return profile.arclength, profile.table["z_mm"][0] - profile.table["z_mm"]
