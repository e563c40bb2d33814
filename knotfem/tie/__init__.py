"""The centreline-displacement mapping that ties a straight rod, and the solid swept along a centreline."""

from knotfem.tie.path import CentrelinePath
from knotfem.tie.paths import KINDS, make_path
from knotfem.tie.sweep import frame_curvature, swept_state

__all__ = ["KINDS", "CentrelinePath", "frame_curvature", "make_path", "swept_state"]
