"""Internal damping of rods, after Kelvin and Voigt: each strain e is met with K (e + tau de/dt).

The rate is the backward difference of a step, so that a step meets a spring of stiffness K tau/dt that is free of
stress where the step set out: the tangent is symmetric and what is dissipated, K tau (e - e_n)^2/dt, never negative.
Stretch and twist are those of `AxialStiffness` and `Twist`; how a bend changes is measured in the section, see
`BendDamping`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from knotfem.geometry.rotation import angle_about, transport
from knotfem.models.rod import damping_kernels as kernels
from knotfem.models.rod.bend import Bend
from knotfem.models.rod.frames import Frames
from knotfem.models.rod.twist import Twist
from knotfem.models.rod.vertices import listed
from knotfem.solver.term import Role, Term, TimeStep
from knotfem.sparse.pattern import Matrix, view_of
from knotfem.terms.axial import AxialStiffness
from knotfem.types import Arrays


class Dashpot(Term, ABC):
    """What the three have in common; their stiffnesses are K tau.

    A step of no length, with which schemes ask for the forces of the accepted state, is met as the last one was.

    Attributes:
        rate: 1/dt of the step [1/s]; 0 before the first.
    """

    name, role = "internal damping", Role.RESISTANCE
    rate = 0.0
    _taken = 0.0
    _first: Arrays
    _last: Arrays

    @abstractmethod
    def strains(self, x: np.ndarray, frames: Frames | None = None) -> Arrays:
        """What must be known of a state to tell how far another is from it.

        Args:
            x: positions and rotations, shape [nodes, 4].
            frames: of the rods there; None for the present ones.
        """

    @abstractmethod
    def potential(self, x: np.ndarray) -> float:
        """Of the forces in a step [N mm]: half of what it dissipates."""

    def at_rest(self, x: np.ndarray, frames: Frames, before: Arrays) -> Arrays:
        """History variables of rods that set out at no rate.

        Args:
            x: positions and rotations, shape [nodes, 4].
            frames: of the rods there.
            before: its history variables in the state that they come from; none for rods that begin.
        """
        here = self.strains(x, frames)
        return _named(here, here, 0.0)

    def begin(self, step: TimeStep) -> None:
        if step.dt > 0.0:
            self._first, self.rate = self._last, 1.0 / step.dt
        self._turn()

    def commit(self, x: np.ndarray) -> None:
        self._taken = 2.0 * self.potential(x)
        self._last = self.strains(x)

    def dissipation(self) -> float:
        return self._taken

    def energy(self, x: np.ndarray) -> float:
        return 0.0

    def merit(self, x: np.ndarray) -> float:
        return self.potential(x)

    def history(self) -> Arrays:
        return _named(self._first, self._last, self.rate)

    def load(self, history: Arrays) -> None:
        if not history:
            self.rate = 0.0
            return
        self._first, self._last = (
            {name.split()[1]: value for name, value in history.items() if name.startswith(which)}
            for which in ("first ", "last ")
        )
        self.rate = float(history["rate"])
        self._turn()

    def _turn(self) -> None:
        """The first state or the rate has changed."""


def _named(first: Arrays, last: Arrays, rate: float) -> Arrays:
    named = {f"first {name}": value for name, value in first.items()}
    return {**named, **{f"last {name}": value for name, value in last.items()}, "rate": np.array(rate)}


class StretchDamping(Dashpot, AxialStiffness):
    """EA tau of all edges [N s]; the axial force is carried as that of the stretch is.

    Args:
        stretch: whose edges are damped.
        time: tau of each edge [s], shape [edges].
    """

    def __init__(self, stretch: AxialStiffness, time: np.ndarray) -> None:
        v, moderate = stretch.view, stretch.merit_stiffness
        AxialStiffness.__init__(self, Dashpot.name, v.nodes, v.length, time * v.stiffness, time * moderate)
        self._damping = self.view.stiffness.copy()
        self._bound = self.merit_stiffness / np.maximum(self._damping, 1e-300)
        self._first = self._last = {}

    def describe(self) -> str:
        return listed(self._damping, "EA tau", "N s")

    def strains(self, x: np.ndarray, frames: Frames | None = None) -> Arrays:
        return {"strain": self.strain(x)}

    def potential(self, x: np.ndarray) -> float:
        return AxialStiffness.energy(self, x)

    def merit(self, x: np.ndarray) -> float:
        return AxialStiffness.merit(self, x)

    def at_rest(self, x: np.ndarray, frames: Frames, before: Arrays) -> Arrays:
        force = before.get("force", np.zeros_like(self.view.force))
        return {**super().at_rest(x, frames, before), "force": force}

    def history(self) -> Arrays:
        return {**AxialStiffness.history(self), **super().history()}

    def load(self, history: Arrays) -> None:
        AxialStiffness.load(self, history)
        super().load(history)

    def _turn(self) -> None:
        if self._first:
            self.view.stiffness[:], self.view.rest[:] = self.rate * self._damping, self._first["strain"]
            self.merit_stiffness = self._bound * self.view.stiffness


class TwistDamping(Dashpot, Twist):
    """C tau of all vertices [N mm^2 s]."""

    def __init__(self, frames: Frames, stiffness: np.ndarray) -> None:
        Twist.__init__(self, frames, stiffness)
        self._first = self._last = {}

    def describe(self) -> str:
        return listed(self.stiffness, "C tau", "N mm^2 s")

    @property
    def modulus(self) -> np.ndarray:
        return self.rate * super().modulus

    @property
    def rest(self) -> np.ndarray:
        return self._first["twist"]

    def strains(self, x: np.ndarray, frames: Frames | None = None) -> Arrays:
        return {"twist": (frames or self.frames).twists(x)}

    def potential(self, x: np.ndarray) -> float:
        return Twist.energy(self, x)


class BendDamping(Dashpot, Bend):
    """B tau of all vertices [N mm^2 s].

    The change of a bend is how far the direction of one edge has moved in the other's material frame, the mean of both
    ways: a bend that keeps its size and goes round the section, as of a bent shaft that spins, is damped too.
    """

    def __init__(self, frames: Frames, stiffness: np.ndarray) -> None:
        Bend.__init__(self, frames, stiffness)
        self._first = self._last = {}
        self._offset = np.zeros(0)

    def describe(self) -> str:
        return listed(self.stiffness, "B tau", "N mm^2 s")

    @property
    def modulus(self) -> np.ndarray:
        return self.rate * super().modulus

    def strains(self, x: np.ndarray, frames: Frames | None = None) -> Arrays:
        tangent, director = (frames or self.frames).current(x)
        return {"tangent": tangent, "director": director, "rotation": x[:, 3] * self.frames.view.per_radius}

    def clamp_couples(self, x: np.ndarray) -> np.ndarray:
        return kernels.clamp_couples(x, self.frames.view, self._view, self.modulus, self.frames.clamped.size)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        return kernels.assemble(
            x, self.frames.view, self._view, self.modulus, residual, view_of(matrix, residual.shape[1])
        )

    def potential(self, x: np.ndarray) -> float:
        return kernels.potential(x, self.frames.view, self._view, self.modulus)

    @property
    def _view(self) -> kernels.FirstView:
        return kernels.FirstView(self._first["tangent"], self._offset)

    def _turn(self) -> None:
        """Find what to add to the rotation of each edge and clamp for its turn about itself since the first state."""
        if not self._first:
            return
        v, nodes = self.frames.view, self.frames.layout.nodes
        tangent, director = self._first["tangent"], self._first["director"]
        clamps = np.zeros(len(tangent) - nodes)
        carried = np.empty(3)
        for c in range(clamps.size):
            now = v.tangent[nodes + c]
            transport(tangent[nodes + c], now, director[nodes + c], carried)
            clamps[c] = angle_about(now, carried, v.director[nodes + c])
        self._offset = np.concatenate([-self._first["rotation"], clamps])


class Damping(NamedTuple):
    """Internal damping of all rods."""

    stretch: StretchDamping
    bend: BendDamping
    twist: TwistDamping


def make_damping(stretch: AxialStiffness, bend: Bend, twist: Twist, frames: Frames, times: Sequence[float]) -> Damping:
    """Internal damping of stretch, bend and twist of all rods.

    Args:
        stretch: of the rods.
        bend: likewise.
        twist: likewise.
        frames: likewise; they come before in the list of terms.
        times: tau of each rod [s].
    """
    tau = np.asarray(times, dtype=float)
    edges = tau[frames.layout.rod[stretch.view.nodes[:, 0]]]
    return Damping(
        StretchDamping(stretch, edges),
        BendDamping(frames, tau * bend.stiffness),
        TwistDamping(frames, tau * twist.stiffness),
    )
