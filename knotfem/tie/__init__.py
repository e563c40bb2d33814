"""Mappings that tie a straight rod into a knot by moving its centreline, and the swept solid along a centreline.

`make_path` chooses one of the mappings `polynomial`, `inextensible`, `linear` and `direct`, which offer the interface
`CentrelinePath`; `swept_state` places the cross-sections. `direction`, `extremes`, `minimax` and `smooth_maximum` serve
the choice of the mapping. Of the project, this package imports `knotfem.geometry`, `compiled`, `errors` and `types`
only.
Source: Aymon, Derveni, Gomez, Crassous and Reis, Extreme Mech. Lett. 81, 102413 (2025), appendix A.
"""

from knotfem.tie.path import CentrelinePath
from knotfem.tie.paths import KINDS, make_path
from knotfem.tie.sweep import frame_curvature, swept_state

__all__ = ["KINDS", "CentrelinePath", "frame_curvature", "make_path", "swept_state"]
