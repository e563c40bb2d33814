"""The Jones polynomial of a link diagram, from the Kauffman bracket."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from knotfem.topology.diagram import Diagram

Matching = tuple[tuple[int, int], ...]
"""How a tangle joins its open ends: pairs of arcs, each pair and the whole in ascending order."""


@dataclass(frozen=True)
class Laurent:
    """A Laurent polynomial in t with integer coefficients.

    Links of an even number of components have half-integer exponents.

    Attributes:
        terms: pairs of twice the exponent and the coefficient, which is not zero, in ascending order.
    """

    terms: tuple[tuple[int, int], ...]

    @staticmethod
    def of(terms: Iterable[tuple[int, int]]) -> Laurent:
        """Polynomial from pairs of twice the exponent and a coefficient, in any order, repeated exponents added up."""
        total: dict[int, int] = {}
        for exponent, coefficient in terms:
            total[exponent] = total.get(exponent, 0) + coefficient
        return Laurent(tuple(sorted((e, c) for e, c in total.items() if c)))

    @staticmethod
    def integer(lowest: int, coefficients: Iterable[int]) -> Laurent:
        """Polynomial with integer exponents lowest, lowest + 1, ..."""
        return Laurent.of((2 * (lowest + k), c) for k, c in enumerate(coefficients))

    def __mul__(self, other: Laurent) -> Laurent:
        """Product of two polynomials."""
        return Laurent.of((e + f, c * d) for e, c in self.terms for f, d in other.terms)

    @property
    def mirror(self) -> Laurent:
        """The polynomial of the mirror image: t replaced by 1/t."""
        return Laurent(tuple((-e, c) for e, c in reversed(self.terms)))

    def __str__(self) -> str:
        """Text such as `t + t^3 - t^4`, in ascending order of the exponents."""
        text = ""
        for twice, coefficient in self.terms:
            power = f"{twice // 2}" if twice % 2 == 0 else f"({twice}/2)"
            variable = {"0": "", "1": "t"}.get(power, f"t^{power}")
            size = "" if abs(coefficient) == 1 and variable else str(abs(coefficient))
            text += (" - " if coefficient < 0 else " + ") + size + variable
        return ("-" if text.startswith(" - ") else "") + text[3:] if text else "0"


def jones(diagram: Diagram) -> Laurent:
    """Jones polynomial of a link: 1 for the unknot, t + t^3 - t^4 for the right-handed trefoil.

    The Kauffman bracket is computed by adding one crossing after another to a tangle. The tangle is a linear
    combination of the ways in which its open ends can be joined, with polynomials in A as coefficients. The cost is
    exponential in the largest number of open ends, not in the number of crossings.
    Source: Kauffman, Topology 26, 395 (1987); Bar-Natan, J. Knot Theory Ramif. 16, 243 (2007) for the order of work.

    Args:
        diagram: of any link; `knotfem.topology.reidemeister.reduce` makes the computation shorter.
    """
    n = len(diagram.crossings)
    if n == 0:
        middle, bracket = 2 * diagram.loops, np.zeros(4 * diagram.loops + 1, dtype=np.int64)
        bracket[middle] = 1
        loops = diagram.loops - 1
    else:
        middle = 3 * n + 2 * diagram.loops + 4
        bracket = _contract(diagram, middle)
        loops = diagram.loops
    for _ in range(loops):
        bracket = _circle(bracket)
    sign = -1 if diagram.writhe % 2 else 1
    exponents = np.flatnonzero(bracket)
    # t = A^-4 and the factor (-A^3)^-writhe: the power of t is (exponent - 3 writhe) / -4.
    return Laurent.of((-(int(e) - middle - 3 * diagram.writhe) // 2, sign * int(bracket[e])) for e in exponents)


def _circle(polynomial: NDArray) -> NDArray:
    """Multiply by the value of a closed circle, -A^2 - A^-2; A^0 keeps its index."""
    return -np.roll(polynomial, 2) - np.roll(polynomial, -2)


def _contract(diagram: Diagram, middle: int) -> NDArray:
    """Kauffman bracket, 1 for a circle, as an array of the coefficients of A^(index - middle)."""
    order = _order(diagram)
    one = np.zeros(2 * middle + 1, dtype=np.int64 if len(order) <= 50 else object)
    one[middle] = 1
    states: dict[Matching, NDArray] = {(): one}
    for number, index in enumerate(order):
        a, b, c, d = diagram.crossings[index]
        last = number == len(order) - 1
        following: dict[Matching, NDArray] = {}
        for matching, polynomial in states.items():
            for power, pairs in ((1, ((a, b), (c, d))), (-1, ((a, d), (b, c)))):
                ends = {end: other for pair in matching for end, other in (pair, pair[::-1])}
                circles = sum(_join(ends, *pair) for pair in pairs)
                term = np.roll(polynomial, power)
                for _ in range(circles - last):
                    term = _circle(term)
                key = tuple(sorted((end, other) for end, other in ends.items() if end < other))
                following[key] = following[key] + term if key in following else term
        states = following
    return states[()]


def _join(ends: dict[int, int], x: int, y: int) -> int:
    """Join the arcs x and y in a tangle; returns 1 if this closes a circle, else 0.

    Args:
        ends: the other open end of each open end, updated.
        x: arc.
        y: arc.
    """
    if x == y:
        return 1
    far = []
    for arc, other in ((x, y), (y, x)):
        if arc in ends:
            end = ends.pop(arc)
            if end == other:
                del ends[other]
                return 1
            far.append(end)
        else:
            far.append(arc)
    ends[far[0]], ends[far[1]] = far[1], far[0]
    return 0


def _order(diagram: Diagram) -> list[int]:
    """Order of the crossings with few open ends of the tangle: the best of the greedy orders from each crossing."""
    arcs = [set(crossing) for crossing in diagram.crossings]
    best: tuple[int, list[int]] | None = None
    for start in range(len(arcs)):
        left, order, cut, width = set(range(len(arcs))), [], set(), 0
        following = start
        while True:
            left.discard(following)
            order.append(following)
            cut = cut ^ {arc for arc in arcs[following] if diagram.crossings[following].count(arc) == 1}
            width = max(width, len(cut))
            if not left:
                break
            following = max(left, key=lambda i: (len(arcs[i] & cut), -i))
        if best is None or width < best[0]:
            best = (width, order)
    return best[1] if best else []
