"""Internal damping of rods, after Kelvin and Voigt: each strain e is met with K (e + tau de/dt).

The rate is the backward difference of a step, so that a step meets a spring of stiffness K tau/dt that is free of
stress where the step set out: the tangent is symmetric and what is dissipated, K tau (e - e_n)^2/dt, never negative.
Stretch and twist are those of `Stretch` and `Twist`; how a bend changes is measured in the section, see `BendDamping`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import ClassVar, NamedTuple

import numpy as np

from knotfem.geometry.rotation import angle_about, transport
from knotfem.models.rod import damping_kernels as kernels
from knotfem.models.rod.bend import Bend
from knotfem.models.rod.frames import Frames
from knotfem.models.rod.stretch import Stretch
from knotfem.models.rod.twist import Twist
from knotfem.solver.term import Arrays, StepStart, Term
from knotfem.sparse.pattern import Matrix
from knotfem.sparse.rod_pattern import matrix_arguments
from knotfem.terms.registry import INTERNAL_DAMPING


class Dashpot(Term, ABC):
    """What the three have in common; their stiffnesses are K tau.

    A step of no length, with which schemes ask for the forces of the accepted state, is met as the last one was.

    Attributes:
        rate: 1/dt of the step [1/s]; 0 before the first.
        dissipated: in the last accepted step [N mm].
        coefficient: name and unit of K tau.
    """

    coefficient: ClassVar[tuple[str, str]]

    def __post_init__(self) -> None:
        super().__post_init__()  # pyright: ignore[reportAttributeAccessIssue]
        self.name, self.viscous = INTERNAL_DAMPING, True
        self.rate = self.dissipated = 0.0
        self._first: Arrays = {}
        self._last: Arrays = {}

    @abstractmethod
    def strains(self, x: np.ndarray) -> Arrays:
        """What must be known of a state to tell how far another is from it."""

    @abstractmethod
    def potential(self, x: np.ndarray) -> float:
        """Of the forces in a step [N mm]: half of what it dissipates."""

    def reset(self, x: np.ndarray) -> None:
        """Set out from x, shape [nodes, 4], at no rate."""
        self.rate = 0.0
        self._first = self._last = self.strains(x)
        self._turn()

    def begin(self, start: StepStart) -> None:
        if start.dt > 0.0:
            self._first, self.rate = self._last, 1.0 / start.dt
        self._turn()

    def commit(self, x: np.ndarray) -> None:
        self.dissipated = 2.0 * self.potential(x)
        self._last = self.strains(x)

    def energy(self, x: np.ndarray) -> float:
        return 0.0

    def history(self) -> Arrays:
        first = {f"first {name}": value for name, value in self._first.items()}
        last = {f"last {name}": value for name, value in self._last.items()}
        return {**super().history(), **first, **last, "rate": np.array(self.rate)}

    def load(self, history: Arrays) -> None:
        super().load(history)
        self._first, self._last = (
            {name.split()[1]: value for name, value in history.items() if name.startswith(which)}
            for which in ("first ", "last ")
        )
        self.rate = float(history["rate"])
        self._turn()

    def _turn(self) -> None:
        """The first state or the rate has changed."""


class StretchDamping(Dashpot, Stretch):
    """EA tau of all edges [N s]; the axial force is carried as that of `Stretch` is."""

    coefficient = "EA tau", "N s"

    def __post_init__(self) -> None:
        super().__post_init__()
        self._damping, self._bound = self._stiffness, self._moderate / np.maximum(self._stiffness, 1e-300)

    def strains(self, x: np.ndarray) -> Arrays:
        return {"strain": self.strain(x)}

    def potential(self, x: np.ndarray) -> float:
        return Stretch.energy(self, x)

    def _turn(self) -> None:
        if self._first:
            self._stiffness, self._rest = self.rate * self._damping, self._first["strain"]
            self._moderate = self._bound * self._stiffness


class TwistDamping(Dashpot, Twist):
    """C tau of all hinges [N mm^2 s]."""

    coefficient = "C tau", "N mm^2 s"

    @property
    def modulus(self) -> np.ndarray:
        return self.rate * super().modulus

    @property
    def rest(self) -> np.ndarray:
        return self._first["twist"]

    def strains(self, x: np.ndarray) -> Arrays:
        return {"twist": self.frames.twists(x)}

    def potential(self, x: np.ndarray) -> float:
        return Twist.energy(self, x)

    def merit(self, x: np.ndarray) -> float:
        return self.potential(x)


class BendDamping(Dashpot, Bend):
    """B tau of all hinges [N mm^2 s].

    The change of a bend is how far the direction of one edge has moved in the other's material frame, the mean of both
    ways: a bend that keeps its size and goes round the section, as of a bent shaft that spins, is damped too.
    """

    coefficient = "B tau", "N mm^2 s"

    @property
    def modulus(self) -> np.ndarray:
        return self.rate * super().modulus

    def strains(self, x: np.ndarray) -> Arrays:
        tangent, director = self.frames.current(x)
        return {"tangent": tangent, "director": director, "spin": x[:, 3] * self.frames.per_radius}

    def clamp_couples(self, x: np.ndarray) -> np.ndarray:
        f = self.frames
        return kernels.clamp_couples(
            x, f.hinges[self._clamped], f.tangent0, self._first["tangent"], self._offset, f.per_radius,
            self.modulus[self._clamped],
        )  # fmt: skip

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        f = self.frames
        return kernels.assemble(
            x, f.hinges, f.stencils, f.tangent0, self._first["tangent"], self._offset, f.per_radius, self.modulus,
            residual, *matrix_arguments(matrix),
        )  # fmt: skip

    def potential(self, x: np.ndarray) -> float:
        f = self.frames
        return kernels.potential(
            x, f.hinges, f.tangent0, self._first["tangent"], self._offset, f.per_radius, self.modulus
        )

    def merit(self, x: np.ndarray) -> float:
        return self.potential(x)

    def _turn(self) -> None:
        """Find what to add to the spin of each edge and clamp for its turn about itself since the first state."""
        if not self._first:
            return
        f, nodes = self.frames, self.frames.layout.nodes
        tangent, director = self._first["tangent"], self._first["director"]
        clamps = np.zeros(len(tangent) - nodes)
        carried = np.empty(3)
        for c in range(clamps.size):
            now = f.tangent0[nodes + c]
            transport(tangent[nodes + c], now, director[nodes + c], carried)
            clamps[c] = angle_about(now, carried, f.director0[nodes + c])
        self._offset = np.concatenate([-self._first["spin"], clamps])


class InternalDamping(NamedTuple):
    """The dashpots of all rods."""

    stretch: StretchDamping
    bend: BendDamping
    twist: TwistDamping


def make_damping(stretch: Stretch, bend: Bend, twist: Twist, frames: Frames, times: Sequence[float]) -> InternalDamping:
    """Internal damping of rods.

    Args:
        stretch: of the rods.
        bend: likewise.
        twist: likewise.
        frames: likewise; they come before in the list of effects.
        times: tau of each rod [s].
    """
    tau = np.asarray(times, dtype=float)
    return InternalDamping(
        StretchDamping(stretch.layout, tau * stretch.stiffness, tau * stretch.merit_stiffness),
        BendDamping(frames, tau * bend.stiffness),
        TwistDamping(frames, tau * twist.stiffness),
    )
