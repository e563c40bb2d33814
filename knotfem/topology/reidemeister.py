"""Fewer crossings, same link: Reidemeister moves I and II on a planar diagram code."""

from __future__ import annotations

from knotfem.topology.diagram import Diagram


class _Code:
    """A planar diagram code under reduction."""

    def __init__(self, diagram: Diagram) -> None:
        self.crossings = {i: list(arcs) for i, arcs in enumerate(diagram.crossings)}
        self.signs = dict(enumerate(diagram.signs))
        self.loops = diagram.loops

    def remove(self, *crossings: int) -> None:
        for crossing in crossings:
            del self.crossings[crossing], self.signs[crossing]

    def join(self, kept: int, dropped: int) -> None:
        """Make one arc of two; an arc joined to itself is a component without crossings."""
        if kept == dropped:
            self.loops += 1
        for arcs in self.crossings.values():
            arcs[:] = [kept if arc == dropped else arc for arc in arcs]

    def untwist(self) -> bool:
        """Reidemeister I: take out a crossing at which one arc comes straight back."""
        for crossing, arcs in self.crossings.items():
            for k in range(4):
                if arcs[k] == arcs[(k + 1) % 4]:
                    self.remove(crossing)
                    self.join(arcs[(k + 2) % 4], arcs[(k + 3) % 4])
                    return True
        return False

    def pull_apart(self) -> bool:
        """Reidemeister II: take out two crossings around a two-sided face of which one side lies over the other.

        With all curls taken out, no arc leads from one side of the face to the other, so the two joins are independent.
        """
        corners: dict[tuple[int, int], tuple[int, int]] = {}
        for crossing, arcs in self.crossings.items():
            for k in range(4):
                corners[arcs[k], arcs[(k + 1) % 4]] = (crossing, k)
        for (a, b), (first, k) in corners.items():
            second, m = corners.get((b, a), (first, 0))
            if second == first or (m + 1 - k) % 2:
                continue
            p, q = self.crossings[first], self.crossings[second]
            self.remove(first, second)
            self.join(p[(k + 2) % 4], q[(m + 3) % 4])
            self.join(p[(k + 3) % 4], q[(m + 2) % 4])
            return True
        return False


def reduce(diagram: Diagram) -> Diagram:
    """Apply moves I and II that remove crossings until there are none left.

    Args:
        diagram: of any link.

    Returns:
        A diagram of the same link with at most as many crossings.
    """
    code = _Code(diagram)
    while code.untwist() or code.pull_apart():
        pass
    kept = list(code.crossings)
    crossings = tuple((a, b, c, d) for a, b, c, d in (code.crossings[i] for i in kept))
    return Diagram(crossings, tuple(code.signs[i] for i in kept), code.loops)
