"""Checks that every effect must pass: tangent against residual, storage, frame indifference."""

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


def residual(effects: Sequence[Term], x: Array) -> Array:
    """Residual of the last effect; all are updated in order first."""
    for effect in effects:
        effect.update(x)
    result = np.zeros_like(x)
    for effect in effects[:-1]:
        effect.assemble(x, np.zeros_like(x), None)
    assert effects[-1].assemble(x, result, None)
    return result


def tangent(effects: Sequence[Term], x: Array, *, upper: bool = False) -> Array:
    """Dense tangent of the last effect, through the sparsity that its own keys give; all are updated first."""
    for effect in effects:
        effect.update(x)
    count = len(x)
    keys = [effect.couplings(count) for effect in effects]
    diagonal = np.arange(count) * (count + 1)
    pattern = Pattern.from_keys(merge_keys(diagonal, *(k for k in keys if k is not None)), count, upper)
    for effect in effects[:-1]:
        effect.assemble(x, np.zeros_like(x), None)
    effects[-1].allocate(pattern)
    matrix = Matrix(pattern)
    assert effects[-1].assemble(x, np.zeros_like(x), matrix), "the keys do not cover the tangent"
    return matrix.to_scipy().toarray()


def directional_error(
    effects: Sequence[Term], x: Array, *, step: float = 1e-6, directions: int = 2, prepare: Callable | None = None
) -> float:
    """Largest deviation of the tangent from central differences of the residual, over the largest entry of the latter.

    `prepare` is called with the positions before each residual, for unknowns that follow them.
    """
    matrix = tangent(effects, x)
    rng = np.random.default_rng(11)
    worst = 0.0
    for _ in range(directions):
        d = rng.standard_normal(x.shape)
        sides = []
        for sign in (1.0, -1.0):
            y = x + sign * step * d
            if prepare is not None:
                prepare(y)
            sides.append(residual(effects, y))
        expected = (sides[0] - sides[1]) / (2.0 * step)
        found = (matrix @ d.ravel()).reshape(-1, 3)
        worst = max(worst, float(np.abs(found - expected).max() / np.abs(expected).max()))
    return worst


def gradient_error(energy: Callable[[Array], float], force: Array, x: Array, *, step: float = 1e-5) -> float:
    """Deviation of a central difference of an energy from force . d in a random direction, over |force| |d|."""
    d = np.random.default_rng(5).standard_normal(x.shape)
    slope = (energy(x + step * d) - energy(x - step * d)) / (2.0 * step)
    return abs(slope - float(np.sum(force * d))) / (np.linalg.norm(force) * np.linalg.norm(d))


def moments(x: Array, force: Array) -> Array:
    """Sum of moments about the origin."""
    return np.cross(x, force).sum(axis=0)
