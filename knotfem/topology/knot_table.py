"""Names of the common knots by their Jones polynomials."""

from __future__ import annotations

from functools import cache

from knotfem.topology.jones import Laurent

PRIME: dict[str, tuple[int, tuple[int, ...]]] = {
    "3_1": (1, (1, 0, 1, -1)),
    "4_1": (-2, (1, -1, 1, -1, 1)),
    "5_1": (2, (1, 0, 1, -1, 1, -1)),
    "5_2": (1, (1, -1, 2, -1, 1, -1)),
    "6_1": (-2, (1, -1, 2, -2, 1, -1, 1)),
    "6_2": (-1, (1, -1, 2, -2, 2, -2, 1)),
    "6_3": (-3, (-1, 2, -2, 3, -2, 2, -1)),
    "7_1": (3, (1, 0, 1, -1, 1, -1, 1, -1)),
    "7_2": (1, (1, -1, 2, -2, 2, -1, 1, -1)),
    "7_3": (2, (1, -1, 2, -2, 3, -2, 1, -1)),
    "7_4": (1, (1, -2, 3, -2, 3, -2, 1, -1)),
    "7_5": (2, (1, -1, 3, -3, 3, -3, 2, -1)),
    "7_6": (-1, (1, -2, 3, -3, 4, -3, 2, -1)),
    "7_7": (-3, (-1, 3, -3, 4, -4, 3, -2, 1)),
    "8_19": (3, (1, 0, 1, 0, 0, -1)),
    "8_20": (-1, (-1, 2, -1, 2, -1, 1, -1)),
    "8_21": (1, (2, -2, 3, -3, 2, -2, 1)),
}
"""Lowest exponent and coefficients of the Jones polynomials of prime knots, by their names in the tables of Rolfsen,
Knots and Links (1976). Of the two mirror images of a chiral knot, it is that with mostly positive exponents."""

COMPOSITE = (
    ("3_1", "3_1"),
    ("3_1", "4_1"),
    ("5_1", "3_1"),
    ("5_2", "3_1"),
    ("4_1", "4_1"),
    ("3_1", "3_1", "3_1"),
)
"""Factors of composite knots, each in all combinations of mirror images."""


@cache
def names() -> dict[Laurent, tuple[str, str]]:
    """Name and handedness of every knot in the tables, by its Jones polynomial.

    The handedness is "right", "left", or "" for a polynomial that equals that of its mirror image.
    """
    table: dict[Laurent, tuple[str, str]] = {Laurent.integer(0, (1,)): ("unknot", "")}
    for factors in [*((name,) for name in PRIME), *COMPOSITE]:
        for flips in range(2 ** (len(factors) - 1)):
            polynomial, words = Laurent.integer(*PRIME[factors[0]]), [factors[0]]
            for k, factor in enumerate(factors[1:]):
                image = Laurent.integer(*PRIME[factor])
                flipped = bool(flips >> (len(factors) - 2 - k) & 1)
                polynomial = polynomial * (image.mirror if flipped else image)
                words.append(f"mirror {factor}" if flipped and image.mirror != image else factor)
            if polynomial in table:
                continue
            mirror = polynomial.mirror
            hands = ("", "") if mirror == polynomial else ("right", "left")
            table[polynomial] = (" # ".join(words), hands[0])
            table[mirror] = (" # ".join(words), hands[-1])
    return table
