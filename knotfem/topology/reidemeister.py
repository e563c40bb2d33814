"""Reduction of link diagrams by the Reidemeister moves I and II that remove crossings."""

from __future__ import annotations

from knotfem.topology.diagram import Diagram


class _Reduction:
    """A diagram in planar diagram code while it is reduced."""

    def __init__(self, diagram: Diagram) -> None:
        self.crossings = {i: list(arcs) for i, arcs in enumerate(diagram.crossings)}
        self.signs = dict(enumerate(diagram.signs))
        self.loops = diagram.loops

    def remove(self, *crossings: int) -> None:
        for crossing in crossings:
            del self.crossings[crossing], self.signs[crossing]

    def join(self, kept: int, dropped: int) -> None:
        """Make one arc of two; an arc that is joined to itself becomes a component without crossings."""
        if kept == dropped:
            self.loops += 1
        for arcs in self.crossings.values():
            arcs[:] = [kept if arc == dropped else arc for arc in arcs]

    def remove_kink(self) -> bool:
        """Reidemeister I: remove a crossing whose two neighbouring ends are one arc; False if there is none."""
        for crossing, arcs in self.crossings.items():
            for k in range(4):
                if arcs[k] == arcs[(k + 1) % 4]:
                    self.remove(crossing)
                    self.join(arcs[(k + 2) % 4], arcs[(k + 3) % 4])
                    return True
        return False

    def remove_bigon(self) -> bool:
        """Reidemeister II: remove the crossings of a face with two sides, one of them over the other at both corners.

        It needs a diagram without kinks, in which no arc leads from one side of the face to the other, so that the two
        strands can be joined independently. Returns False if there is no such face.
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
    """Apply Reidemeister moves I and II that remove crossings until none is possible.

    Args:
        diagram: of any link.

    Returns:
        A diagram of the same link, which need not have the smallest possible number of crossings.
    """
    reduction = _Reduction(diagram)
    while reduction.remove_kink() or reduction.remove_bigon():
        pass
    kept = list(reduction.crossings)
    crossings = tuple((a, b, c, d) for a, b, c, d in (reduction.crossings[i] for i in kept))
    return Diagram(crossings, tuple(reduction.signs[i] for i in kept), reduction.loops)
