"""Checks that every term must pass: tangent against residual, storage, frame indifference."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from knotfem.solver.term import Term
from knotfem.sparse.pattern import Matrix, Pattern, merge_keys

Array = np.ndarray


def rotation(seed: int = 7) -> Array:
    """A proper rotation far from the identity."""
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def residual(terms: Sequence[Term], x: Array) -> Array:
    """Residual of the last term; all are updated in order first."""
    for term in terms:
        term.update(x)
    result = np.zeros_like(x)
    for term in terms[:-1]:
        term.assemble(x, np.zeros_like(x), None)
    assert terms[-1].assemble(x, result, None)
    return result


def tangent(terms: Sequence[Term], x: Array, *, upper: bool = False) -> Array:
    """Dense tangent of the last term, through the sparsity that the couplings of all give; all are updated first."""
    for term in terms:
        term.update(x)
    count = len(x)
    couplings = [term.couplings(count) for term in terms]
    diagonal = np.arange(count) * (count + 1)
    pattern = Pattern.from_keys(
        merge_keys(diagonal, *(k for k in couplings if k is not None)), count, upper, x.shape[1]
    )
    for term in terms[:-1]:
        term.assemble(x, np.zeros_like(x), None)
    terms[-1].allocate(pattern)
    matrix = Matrix(pattern)
    assert terms[-1].assemble(x, np.zeros_like(x), matrix), "the couplings do not cover the tangent"
    return matrix.to_scipy().toarray()


def directional_error(
    terms: Sequence[Term], x: Array, *, step: float = 1e-6, directions: int = 2, prepare: Callable | None = None
) -> float:
    """Largest deviation of the tangent from central differences of the residual, over the largest entry of the latter.

    `prepare` is called with the positions before each residual, for unknowns that follow them.
    """
    matrix = tangent(terms, x)
    rng = np.random.default_rng(11)
    worst = 0.0
    for _ in range(directions):
        d = rng.standard_normal(x.shape)
        sides = []
        for sign in (1.0, -1.0):
            y = x + sign * step * d
            if prepare is not None:
                prepare(y)
            sides.append(residual(terms, y))
        expected = (sides[0] - sides[1]) / (2.0 * step)
        found = (matrix @ d.ravel()).reshape(x.shape)
        worst = max(worst, float(np.abs(found - expected).max() / np.abs(expected).max()))
    return worst


def gradient_error(energy: Callable[[Array], float], force: Array, x: Array, *, step: float = 1e-5) -> float:
    """Deviation of a central difference of an energy from force . d in a random direction, over |force| |d|."""
    d = np.random.default_rng(5).standard_normal(x.shape)
    slope = (energy(x + step * d) - energy(x - step * d)) / (2.0 * step)
    return abs(slope - float(np.sum(force * d))) / float(np.linalg.norm(force) * np.linalg.norm(d))


def assert_symmetric_storage(terms: Sequence[Term], x: Array, *, tolerance: float) -> None:
    """The last term's tangent is symmetric, and its upper triangle alone is stored to the same; relative tolerance."""
    whole = tangent(terms, x)
    atol = tolerance * np.abs(whole).max()
    np.testing.assert_allclose(whole, whole.T, atol=atol)
    np.testing.assert_allclose(tangent(terms, x, upper=True), whole, atol=atol)


def assert_energy_gradient(contact: Term, x: Array) -> None:
    """The residual of a contact term is the gradient of its energy, which is its merit too."""

    def energy(y: Array) -> float:
        contact.update(y)
        return contact.energy(y)

    f = residual([contact], x)
    assert gradient_error(energy, f, x, step=1e-6) < 1e-6
    np.testing.assert_allclose(contact.merit(x), energy(x), rtol=1e-12)


def moments(x: Array, force: Array) -> Array:
    """Sum of moments about the origin."""
    return np.cross(x, force).sum(axis=0)
