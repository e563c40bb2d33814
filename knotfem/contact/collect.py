"""Collects the samples in contact from the terms of a model."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from knotfem.contact.pairs import PairContact
from knotfem.contact.report import ContactReport
from knotfem.contact.stations import arclengths
from knotfem.solver.term import Role, Term

if TYPE_CHECKING:
    from knotfem.contact.friction import Friction
    from knotfem.contact.obstacle import ObstacleContact


def contact_report(terms: Sequence[Term]) -> ContactReport:
    """Collect the samples that carry force, from the contact and friction terms as last assembled."""
    friction = _frictions(terms)
    obstacles = _obstacles(terms)
    parts: list[tuple[np.ndarray, ...]] = []
    for term in terms:
        if isinstance(term, PairContact):
            pairs = term.pairs
            on = np.flatnonzero(pairs.force > 0.0)
            other = pairs.rod[on]
            there = arclengths(term.surface.stations, other, pairs.at[on, 0])
            where = (*_where(term, pairs.sample[on]), other, there)
            normal = term.normals(on)
            parts.append((*where, pairs.gap[on], normal, pairs.force[on], *_friction_of(friction.get(id(term)), on)))
    for number, term in enumerate(obstacles):
        touch = term.touch
        near = touch.force[touch.sample] > 0.0
        on = touch.sample[near]
        other, nowhere = np.full(on.size, -1 - number), np.full(on.size, np.nan)
        pressing = touch.gap[near], touch.normal[near], touch.force[on]
        parts.append((*_where(term, on), other, nowhere, *pressing, *_friction_of(friction.get(id(term)), on)))
    if not parts:
        return ContactReport.empty()
    return ContactReport(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def _frictions(terms: Sequence[Term]) -> dict[int, Friction]:
    """Friction terms by the identity of their contact."""
    if not any(term.role is Role.FRICTION for term in terms):
        return {}
    from knotfem.contact.friction import Friction

    return {id(term.contact): term for term in terms if isinstance(term, Friction)}


def _obstacles(terms: Sequence[Term]) -> list[ObstacleContact]:
    if not any(term.role is Role.CONTACT and term.external for term in terms):
        return []
    from knotfem.contact.obstacle import ObstacleContact

    return [term for term in terms if isinstance(term, ObstacleContact)]


def _where(contact: PairContact | ObstacleContact, sample: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    rod = contact.samples.rod[sample]
    return rod, arclengths(contact.surface.stations, rod, contact.samples.u[sample])


def _friction_of(friction: Friction | None, on: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    if friction is None:
        return np.zeros(on.size), np.ones(on.size, dtype=bool)
    return np.linalg.norm(friction.view.traction[on], axis=1), friction.slides[on] | (friction.mu[on] == 0.0)
