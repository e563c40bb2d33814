import time
from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from knotfem.topology.diagram import Diagram, diagram
from knotfem.topology.jones import Laurent, jones

Array = NDArray[np.float64]
ABOVE = (0.01, 0.02, 1.0)


def torus_knot(p: int, q: int) -> Laurent:
    """t^((p-1)(q-1)/2) (1 - t^(p+1) - t^(q+1) + t^(p+q)) / (1 - t^2), divided out."""
    numerator = np.zeros(p + q + 1, dtype=int)
    for exponent, sign in ((0, 1), (p + 1, -1), (q + 1, -1), (p + q, 1)):
        numerator[exponent] += sign
    quotient = numerator.copy()
    for k in range(2, len(quotient)):
        quotient[k] += quotient[k - 2]
    return Laurent.integer((p - 1) * (q - 1) // 2, quotient.tolist())


def test_trefoil_of_the_knot_atlas_is_left_handed() -> None:
    left = Diagram(((1, 4, 2, 5), (3, 6, 4, 1), (5, 2, 6, 3)), (-1, -1, -1))
    assert str(jones(left)) == "-t^-4 + t^-3 + t^-1"
    assert str(jones(left).mirror) == "t + t^3 - t^4"


def test_figure_eight_of_the_knot_atlas() -> None:
    eight = Diagram(((4, 2, 5, 1), (8, 6, 1, 5), (6, 3, 7, 4), (2, 7, 3, 8)), (1, 1, -1, -1))
    assert str(jones(eight)) == "t^-2 - t^-1 + 1 - t + t^2"


@pytest.mark.parametrize(("curl", "sign"), [((1, 1, 2, 2), 1), ((2, 1, 1, 2), -1)])
def test_curls_do_not_count(curl: tuple[int, int, int, int], sign: int) -> None:
    assert str(jones(Diagram((curl,), (sign,)))) == "1"


def test_loops() -> None:
    assert str(jones(Diagram((), (), 1))) == "1"
    assert str(jones(Diagram((), (), 2))) == "-t^(-1/2) - t^(1/2)"
    assert str(jones(Diagram((), (), 3))) == "t^-1 + 2 + t"


@pytest.mark.parametrize(("p", "q"), [(2, 3), (2, 7), (3, 4), (3, 5), (4, 5)])
def test_torus_knots(closed_braid: Callable[[list[int]], list[Array]], p: int, q: int) -> None:
    assert jones(diagram(closed_braid(list(range(1, p)) * q), ABOVE)) == torus_knot(p, q)


@pytest.mark.parametrize(
    ("word", "expected"),
    [
        ([1, 1], "-t^(1/2) - t^(5/2)"),
        ([1] * 4, "-t^(3/2) - t^(7/2) + t^(9/2) - t^(11/2)"),
        ([1, -2] * 3, "-t^-3 + 3t^-2 - 2t^-1 + 4 - 2t + 3t^2 - t^3"),
    ],
)
def test_links(closed_braid: Callable[[list[int]], list[Array]], word: list[int], expected: str) -> None:
    """Hopf link, Solomon's link, Borromean rings."""
    assert str(jones(diagram(closed_braid(word), ABOVE))) == expected


def test_split_link_with_crossings(closed_braid: Callable[[list[int]], list[Array]]) -> None:
    trefoil = jones(diagram(closed_braid([1, 1, 1]), ABOVE))
    both = jones(
        diagram([*closed_braid([1, 1, 1]), *(x + np.array([40, 0, 0]) for x in closed_braid([1, 1, 1]))], ABOVE)
    )
    assert both == trefoil * trefoil * Laurent(((-1, -1), (1, -1)))


def test_value_at_one_counts_components(closed_braid: Callable[[list[int]], list[Array]]) -> None:
    for word, components in (([1, -2, 1, -2], 1), ([1, 1, 2, 2], 3), ([1, -2, 1, -2, 1], 2)):
        polygons = closed_braid(word)
        assert len(polygons) == components
        assert sum(c for _, c in jones(diagram(polygons, ABOVE)).terms) == (-2) ** (components - 1)


def test_power_of_a_binomial() -> None:
    n = 12
    word = Laurent.integer(0, (1, 1))
    power = Laurent.integer(0, (1,))
    for _ in range(n):
        power = power * word
    assert dict(power.terms)[n] == 924


def test_polynomial_text() -> None:
    assert str(Laurent(())) == "0"
    assert str(Laurent.integer(-1, (-1, 2, 0, -3))) == "-t^-1 + 2 - 3t^2"
    assert str(Laurent.integer(0, (1, 1))) == "1 + t"
    assert Laurent.integer(-1, (1, 2, 3)).mirror == Laurent.integer(-1, (3, 2, 1))


def test_twenty_five_crossings_are_quick(closed_braid: Callable[[list[int]], list[Array]]) -> None:
    whole = diagram(closed_braid([1, 2, 3, 4, 5] * 5), ABOVE)
    assert len(whole.crossings) == 25
    begin = time.perf_counter()
    assert jones(whole) == torus_knot(5, 6)
    assert time.perf_counter() - begin < 0.5
