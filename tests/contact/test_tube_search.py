import numpy as np
from specimens import make_rod, surfaces

from knotfem.contact.law import Penalty
from knotfem.contact.pairs import PairContact


def test_every_close_sample_is_found(crossing):
    """Against the distance of all samples to the straight axes of the other rod."""
    contact, x = crossing.contact, crossing.x
    contact.update(x)
    samples = contact.samples
    points = samples.places(x)
    paired = {(int(s), int(r)) for s, r in zip(contact.pairs.sample, contact.pairs.rod, strict=True)}
    expected = set()
    for secondary, primary in ((0, 1), (1, 0)):
        axis = x[crossing.rods[primary].axis]
        t = (axis[-1] - axis[0]) / np.linalg.norm(axis[-1] - axis[0])
        for s in np.flatnonzero(samples.rod == secondary):
            arm = points[s] - axis[0]
            along = arm @ t
            distance = np.linalg.norm(arm - along * t) - 3.0
            if distance < 0.7 * contact.reach and 0.0 < along < 30.0:
                expected.add((int(s), primary))
    assert len(expected) > 40
    assert expected <= paired


def test_pairs_are_sorted_and_unique(crossing):
    crossing.contact.update(crossing.x)
    pairs = crossing.contact.pairs
    keys = pairs.sample * 2 + pairs.rod
    assert (np.diff(keys) > 0).all()


def test_a_sample_may_touch_two_strands(make_crossing):
    """Three rods side by side: the middle one's samples meet both neighbours, none meets its own rod."""
    rods, parts, first = [], [], 0
    for offset in (-5.95, 0.0, 5.95):
        rods.append(make_rod(12.0, 6, first=first))
        parts.append(rods[-1].mesh.nodes + np.array([offset, 0.0, 0.0]))
        first += len(parts[-1])
    contact = PairContact(*surfaces(rods, 0.75), Penalty(11.4, 0.2))
    contact.update(np.vstack(parts))
    own, other = contact.samples.rod[contact.pairs.sample], contact.pairs.rod
    assert (own != other).all()
    assert set(other[own == 1]) == {0, 2}
    assert set(other[own == 0]) == {1}
