"""Cards of an Abaqus or CalculiX deck: sections, materials and static steps that carry the ends of a rod.

meshio writes nodes, elements and sets of a `.inp` file and no more; these cards make a deck of it that CalculiX runs as
it is. Units are mm, N, MPa, tonne and s.

Hexahedra are C3D8I, whose incompatible modes keep them from locking in bending; for a bulk that is incompressible
Abaqus has C3D8H and C3D8IH. The core is a chain of springs along the axis (SPRINGA) rather than of trusses (T3D2):
CalculiX makes three-dimensional elements of trusses, and does not converge when a core of a thousand times the bulk's
stiffness turns by more than some ten degrees. The springs have the same law.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

TURN = np.radians(15.0)
"""Largest rotation of an end within one step: the displacements of a step grow in proportion, which shrinks a section
that turns."""


@dataclass(frozen=True)
class Solid:
    """A nearly incompressible neo-Hookean bulk.

    Attributes:
        group: of the hexahedra.
        shear_modulus: mu [MPa].
        bulk_modulus: kappa [MPa].
        density: [tonne/mm^3].
    """

    group: str
    shear_modulus: float
    bulk_modulus: float
    density: float

    @property
    def cards(self) -> str:
        """W = C10 (I1 - 3) + (J - 1)^2 / D1."""
        return (
            f"*MATERIAL, NAME={self.group}\n*HYPERELASTIC, NEO HOOKE\n"
            f"{0.5 * self.shear_modulus:.12g}, {2.0 / self.bulk_modulus:.12g}\n*DENSITY\n{self.density:.12g}\n"
            f"*SOLID SECTION, ELSET={self.group}, MATERIAL={self.group}\n"
        )


@dataclass(frozen=True)
class Springs:
    """A core, edge by edge: the linear truss of `knotfem.terms.axial`, force EA (l/h - 1) along the edge.

    Attributes:
        group: of the lines.
        stiffness: EA/h of all its edges [N/mm].
    """

    group: str
    stiffness: float

    @property
    def cards(self) -> str:
        """One stiffness for all edges; the empty line is for directions, which an axial spring has none of."""
        return f"*SPRING, ELSET={self.group}\n\n{self.stiffness:.12g}\n"


def deck(
    materials: Sequence[Solid | Springs],
    held: Sequence[str],
    stages: Sequence[Mapping[int, np.ndarray]] = (),
    *,
    increment: float = 0.1,
) -> str:
    """Cards of materials, sections and one static step with large deformations for each stage.

    Args:
        materials: of the groups.
        held: node sets that do not move.
        stages: displacement [mm], shape [3], of each moved node, counted from 0, at the end of each step; none for one
            step in which nothing moves.
        increment: first increment over the length of a step.
    """
    fixed = "".join(f"{name}, 1, 3\n" for name in held)
    printed = "".join(f"*NODE PRINT, NSET={name}, FREQUENCY=1000\nRF\n" for name in held)
    output = f"*NODE FILE\nU, RF\n*EL FILE\nS\n{printed}"
    steps = []
    for stage in stages or ({},):
        moved = "".join(
            f"{node + 1}, {axis}, {axis}, {value:.12g}\n"
            for node, vector in sorted(stage.items())
            for axis, value in enumerate(vector, start=1)
        )
        steps.append(
            f"*STEP, NLGEOM, INC=1000\n*STATIC\n{increment:g}, 1.0\n"
            + (f"*BOUNDARY\n{moved}" if moved else "")
            + f"{output}*END STEP\n"
        )
    return "".join(material.cards for material in materials) + f"*BOUNDARY\n{fixed}" + "".join(steps)


def rigid_motion(points: np.ndarray, moved: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The rotation, shape [3, 3], and the centres before and after, of the rigid motion nearest to a motion (Kabsch).

    Args:
        points: before, shape [n, 3].
        moved: after, shape [n, 3].
    """
    before, after = points.mean(axis=0), moved.mean(axis=0)
    u, _, vt = np.linalg.svd((moved - after).T @ (points - before))
    u[:, 2] *= np.sign(np.linalg.det(u @ vt))
    return u @ vt, before, after


def carried(points: np.ndarray, moved: np.ndarray) -> list[np.ndarray]:
    """Places of a section at the end of each stage of a motion in which no stage turns it by more than `TURN`.

    The centre moves on a straight line, the section turns about a fixed axis, and what is left of the motion, the
    section's own deformation, grows in proportion.

    Args:
        points: before, shape [n, 3].
        moved: after, shape [n, 3].
    """
    from scipy.spatial.transform import Rotation

    matrix, before, after = rigid_motion(points, moved)
    vector = Rotation.from_matrix(matrix).as_rotvec()
    own = (moved - after) @ matrix - (points - before)
    count = max(1, int(np.ceil(np.linalg.norm(vector) / TURN - 1e-9)))
    stages = []
    for part in np.arange(1, count + 1) / count:
        turn = Rotation.from_rotvec(part * vector).as_matrix()
        stages.append(before + part * (after - before) + (points - before + part * own) @ turn.T)
    return stages
