"""The Jones polynomial by Kauffman's bracket, crossing by crossing."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from knotfem.topology.diagram import Diagram

Matching = tuple[tuple[int, int], ...]


@dataclass(frozen=True)
class Laurent:
    """A Laurent polynomial in t with integer coefficients; half powers occur for links of an even number of components.

    Attributes:
        terms: (twice the exponent, coefficient other than 0), exponents rising.
    """

    terms: tuple[tuple[int, int], ...]

    @staticmethod
    def of(terms: Iterable[tuple[int, int]]) -> Laurent:
        """Collect (twice the exponent, coefficient) pairs in any order."""
        total: dict[int, int] = {}
        for exponent, coefficient in terms:
            total[exponent] = total.get(exponent, 0) + coefficient
        return Laurent(tuple(sorted((e, c) for e, c in total.items() if c)))

    @staticmethod
    def integer(lowest: int, coefficients: Iterable[int]) -> Laurent:
        """Polynomial with whole exponents lowest, lowest + 1, ..."""
        return Laurent.of((2 * (lowest + k), c) for k, c in enumerate(coefficients))

    def __mul__(self, other: Laurent) -> Laurent:
        """Product."""
        return Laurent.of((e + f, c * d) for e, c in self.terms for f, d in other.terms)

    @property
    def mirror(self) -> Laurent:
        """The polynomial of the mirror image: t replaced by 1/t."""
        return Laurent(tuple((-e, c) for e, c in reversed(self.terms)))

    def __str__(self) -> str:
        """Such as `t + t^3 - t^4`, exponents rising."""
        text = ""
        for twice, coefficient in self.terms:
            power = f"{twice // 2}" if twice % 2 == 0 else f"({twice}/2)"
            variable = {"0": "", "1": "t"}.get(power, f"t^{power}")
            size = "" if abs(coefficient) == 1 and variable else str(abs(coefficient))
            text += (" - " if coefficient < 0 else " + ") + size + variable
        return ("-" if text.startswith(" - ") else "") + text[3:] if text else "0"


def jones(diagram: Diagram) -> Laurent:
    """Jones polynomial; the right-handed trefoil has t + t^3 - t^4, the unknot 1.

    The bracket is contracted over a growing part of the plane: for every way in which that part joins the arcs it cuts,
    one polynomial in A. Cost grows with the width of the diagram, not with 2^crossings.
    Source: Kauffman, Topology 26, 395 (1987); Bar-Natan's planar algorithm for the order of work.

    Args:
        diagram: of any link; fewest crossings first pays (`reduce`).
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
    """Multiply by the value of a closed circle, -A^2 - A^-2; the middle stays where it is."""
    return -np.roll(polynomial, 2) - np.roll(polynomial, -2)


def _contract(diagram: Diagram, middle: int) -> NDArray:
    """Kauffman bracket, normalised to 1 for one circle, as coefficients of A^(index - middle)."""
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
    """Add a path from arc x to arc y to the open paths; returns 1 if it closes a circle."""
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
    """Order of the crossings that keeps few arcs cut: greedy from the best start."""
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
