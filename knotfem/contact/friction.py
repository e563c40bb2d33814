"""Coulomb friction of contacts: what they remember, and when it changes.

Each contact remembers the anchor to which it sticks. Anchors change on accepted steps alone: those of contacts that
slide are dragged along, those of contacts that do not touch are set where they would touch. Contacts near to touching
are therefore anchored before they touch; an anchor set at the first overlap would bias friction low and make it depend
on the step. Nothing creeps, as it would with a friction regularised by velocity.
"""

from __future__ import annotations

from typing import Any, Protocol

import numpy as np

from knotfem.contact.samples import Samples
from knotfem.contact.surface import Surface
from knotfem.solver.term import Role, Term, TimeStep
from knotfem.sparse.pattern import Matrix, stencil_keys, view_of
from knotfem.sparse.scatter import MatrixView
from knotfem.types import Arrays


class Contact(Protocol):
    """What friction asks of the term of normal contact.

    Attributes:
        name, number: of the term.
        external: whether an obstacle is touched.
        surface: of all rods.
        samples: of it.
        generation: number of searches; where it has changed, the contacts are others.
        match: where each contact stood before the last search, or -1, shape [contacts].
    """

    name: str
    number: int
    external: bool
    surface: Surface
    samples: Samples
    generation: int
    match: np.ndarray

    def coefficients(self, table: np.ndarray) -> np.ndarray:
        """Coefficient of each contact, shape [contacts], from those of rods; see `Friction`."""
        ...


class FrictionView(Protocol):
    """What every friction law fills in for each contact.

    Attributes:
        slip: distance of the contact from its anchor [mm], shape [contacts].
        traction: friction force on the secondary surface [N], shape [contacts, 3].
        stick: distance over which friction is mobilised [mm].
    """

    @property
    def slip(self) -> np.ndarray: ...
    @property
    def traction(self) -> np.ndarray: ...
    @property
    def stick(self) -> float: ...


class FrictionLaw(Protocol):
    """How friction follows from slip, for one kind of contact.

    What a contact remembers are rows of arrays, made by `fresh` and named as history variables.
    """

    def fresh(self, contact: Any, count: int) -> dict[str, np.ndarray]:
        """Rows of contacts that remember nothing yet."""
        ...

    def view(self, contact: Any, mu: np.ndarray, rows: dict[str, np.ndarray]) -> Any:
        """Arguments of compiled loops."""
        ...

    def assemble(self, x: np.ndarray, contact: Any, view: Any, residual: np.ndarray, matrix: MatrixView) -> bool:
        """Add residual and tangent. False where a block lies outside the pattern."""
        ...

    def potential(self, x: np.ndarray, contact: Any, view: Any) -> float:
        """Friction potential at x with the normal forces last assembled, for the line search."""
        ...

    def commit(self, x: np.ndarray, contact: Any, view: Any) -> None:
        """Bring sliding contacts along, and anchor those that do not touch."""
        ...

    def anchor(self, x: np.ndarray, contact: Any, view: Any, chosen: np.ndarray) -> None:
        """Anchor the chosen contacts, boolean, where they are."""
        ...

    def sliding(self, contact: Any, view: Any) -> np.ndarray:
        """Whether each contact slides, boolean, shape [contacts]."""
        ...

    def stencils(self, contact: Any, view: Any) -> np.ndarray | None:
        """Nodes that friction couples beyond those of normal contact, shape [stencils, nodes]."""
        ...


class Friction(Term):
    """Friction of the contacts of one normal contact term, which must come before it in the list of terms.

    Args:
        contact: whose contacts have friction.
        law: of its kind.
        coefficients: mu of each pair of rods, shape [rods, rods], or of each rod on an obstacle, shape [rods].
        scheduled: whether the conditions of a step may multiply the coefficients.

    Attributes:
        view: of the law, one row for each contact.
    """

    name, role, symmetric = "friction", Role.FRICTION, False

    def __init__(self, contact: Contact, law: FrictionLaw, coefficients: np.ndarray, *, scheduled: bool = True) -> None:
        self.contact, self.law = contact, law
        self.coefficients = np.asarray(coefficients, dtype=float)
        self._scheduled = scheduled
        self.external, self.number = contact.external, contact.number
        self.name = f"{contact.name} friction" if contact.external else "friction"
        self._factor = 1.0
        self.load({})

    def describe(self) -> str:
        return f"mu {', '.join(f'{mu:g}' for mu in np.unique(self.coefficients))}"

    def couplings(self, nodes: int) -> np.ndarray | None:
        stencils = self.law.stencils(self.contact, self.view)
        return None if stencils is None or not stencils.size else stencil_keys(stencils, nodes)

    def begin(self, step: TimeStep) -> None:
        schedule = step.conditions.friction if self._scheduled else None
        factor = self._factor if schedule is None else schedule(step.end)
        if factor != self._factor:
            self._factor = factor
            self._make_view()

    def update(self, x: np.ndarray) -> None:
        contact = self.contact
        if self._generation == contact.generation:
            return
        known = (contact.match >= 0) & self._remembers
        rows = self.law.fresh(contact, len(known))
        for name, row in rows.items():
            row[known] = self._rows[name][contact.match[known]]
        self._rows, self._generation, self._remembers = rows, contact.generation, True
        self._make_view()
        self.law.anchor(x, contact, self.view, ~known)

    def assemble(self, x: np.ndarray, residual: np.ndarray, matrix: Matrix | None) -> bool:
        return self.law.assemble(x, self.contact, self.view, residual, view_of(matrix, residual.shape[1]))

    def merit(self, x: np.ndarray) -> float:
        return self.law.potential(x, self.contact, self.view)

    def commit(self, x: np.ndarray) -> None:
        self.law.commit(x, self.contact, self.view)

    def slip(self) -> float:
        rubbing = self.view.traction.any(axis=1)
        return float(max(self.view.slip[rubbing].max(initial=0.0) - self.view.stick, 0.0))

    def history(self) -> Arrays:
        rows = {name: row.copy() for name, row in self._rows.items()} if self._remembers else {}
        return {**rows, "factor": np.array(self._factor)}

    def load(self, history: Arrays) -> None:
        fresh = self.law.fresh(self.contact, len(self.contact.match))
        self._remembers = bool(history) and all(name in history for name in fresh)
        self._rows = {name: history[name].copy() for name in fresh} if self._remembers else fresh
        self._factor = float(history.get("factor", 1.0))
        self._generation = self.contact.generation if self._remembers else -1
        self._make_view()

    @property
    def slides(self) -> np.ndarray:
        """Whether each contact slides, boolean, shape [contacts]."""
        return self.law.sliding(self.contact, self.view)

    @property
    def sliding(self) -> int:
        """Number of contacts that slide."""
        return int(np.count_nonzero(self.slides))

    @property
    def mu(self) -> np.ndarray:
        """Coefficient of each contact, shape [contacts]."""
        return self._factor * self.contact.coefficients(self.coefficients)

    def _make_view(self) -> None:
        self.view: Any = self.law.view(self.contact, self.mu, self._rows)
