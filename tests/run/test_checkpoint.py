"""Checkpoints come back to the last bit."""

import errno
import math
import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as npst

from knotfem.errors import InputError
from knotfem.run.checkpoint import CheckpointStore


def same(one: Any, other: Any) -> bool:
    """Same type, shape, layout and bits."""
    if isinstance(one, dict):
        return isinstance(other, dict) and one.keys() == other.keys() and all(same(one[k], other[k]) for k in one)
    if isinstance(one, list | tuple):
        return type(one) is type(other) and len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, np.ndarray | np.generic):
        alike = type(one) is type(other) and (one.dtype, one.shape) == (other.dtype, other.shape)
        return alike and one.tobytes() == other.tobytes()
    return type(one) is type(other) and (one == other or (math.isnan(one) and math.isnan(other)))


STATE: dict[str, Any] = {
    "x": np.linspace(0.0, 1.0, 30).reshape(10, 3) / 3.0,
    "fortran": np.asfortranarray(np.arange(6.0).reshape(2, 3)),
    "strided": np.arange(10.0)[::2],
    "empty": np.zeros((0, 3)),
    "zero-d": np.array(0.1),
    "flags": np.array([True, False]),
    "pairs": np.arange(4, dtype=np.int32),
    "special": np.array([np.nan, np.inf, -np.inf, -0.0, 5e-324]),
    "scalar": np.float64(0.1) + np.float64(0.2),
    "friction": {"anchors": {"patch": np.arange(3), "count": 12}, "none": None, "text": "µ", "yes": True},
    "control": {"step": 0.1 + 0.2, "nan": math.nan, "huge": 2**127 + 1, "history": [1, 2.5, np.arange(2)]},
    "tuple": (1, (2.0, np.float32(0.3)), []),
}


def test_bit_for_bit(tmp_path: Path) -> None:
    store = CheckpointStore(tmp_path / "checkpoints")
    assert store.latest() is None
    metadata = {"step": 3, "rows": {"force.csv": 12}, "time": 0.1}
    path = store.save(STATE, metadata)
    checkpoint = store.latest()
    assert checkpoint is not None
    assert checkpoint.path == path
    assert checkpoint.metadata == metadata
    assert same(STATE, checkpoint.state)


def test_memory_layout_is_kept(tmp_path: Path) -> None:
    """Sums of arrays depend on it in the last bit."""
    store = CheckpointStore(tmp_path / "checkpoints")
    store.save(STATE, {})
    checkpoint = store.latest()
    assert checkpoint is not None
    assert checkpoint.state["fortran"].flags.f_contiguous
    assert not checkpoint.state["fortran"].flags.c_contiguous
    assert checkpoint.state["x"].flags.c_contiguous
    assert checkpoint.state["x"].flags.writeable


@given(
    array=npst.arrays(
        st.sampled_from([np.float64, np.float32, np.int64, np.uint8, np.bool_, np.complex128]),
        npst.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=3),
    )
)
def test_any_array(tmp_path_factory: pytest.TempPathFactory, array: np.ndarray) -> None:
    store = CheckpointStore(tmp_path_factory.getbasetemp() / "any")
    store.save({"a": array}, {})
    checkpoint = store.latest()
    assert checkpoint is not None
    assert same({"a": array}, checkpoint.state)


def test_keeps_the_newest_and_the_named(tmp_path: Path) -> None:
    store = CheckpointStore(tmp_path, keep=2)
    store.save({"step": 0}, {})
    tied = store.save({"step": 1}, {}, name="tied")
    for step in range(2, 6):
        store.save({"step": step}, {})
    assert store.named("tied") == tied
    assert store.named("other") is None
    assert [path.name for path in store.paths()] == [
        "checkpoint-000002-tied.h5",
        "checkpoint-000005.h5",
        "checkpoint-000006.h5",
    ]
    newest = store.latest()
    assert newest is not None
    assert newest.state == {"step": 5}
    again = store.save({"step": 6}, {}, name="tied")
    assert store.named("tied") == again
    assert len(store.paths()) == 3


def test_adopts_from_another_run(tmp_path: Path) -> None:
    one, other = CheckpointStore(tmp_path / "one"), CheckpointStore(tmp_path / "other")
    other.adopt(one.save(STATE, {"a": 1}, name="tied"))
    checkpoint = other.latest()
    assert checkpoint is not None
    assert other.named("tied") == checkpoint.path
    assert same(STATE, checkpoint.state)


@pytest.mark.parametrize(
    "state", [{1: 2}, {"$array": 1}, {"a": {1, 2}}, {"a": np.array(["x"])}, {"a": np.array([object()])}]
)
def test_what_cannot_be_kept_is_refused(tmp_path: Path, state: dict[str, Any]) -> None:
    with pytest.raises(TypeError, match="a checkpoint takes"):
        CheckpointStore(tmp_path).save(state, {})
    assert os.listdir(tmp_path) == []


def test_a_full_disk_keeps_the_older_ones(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    store = CheckpointStore(tmp_path, keep=1)
    store.save({"step": 1}, {})

    def full(descriptor: int) -> None:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    with pytest.raises(InputError, match="No space left"):
        store.save({"step": 2}, {})
    assert os.listdir(tmp_path) == ["checkpoint-000001.h5"]
    checkpoint = store.latest()
    assert checkpoint is not None
    assert checkpoint.state == {"step": 1}


@pytest.mark.parametrize("content", [b"", b"no HDF5"])
def test_damaged_checkpoints_are_named(tmp_path: Path, content: bytes) -> None:
    store = CheckpointStore(tmp_path)
    path = store.save(STATE, {})
    path.write_bytes(content or path.read_bytes()[:-500])
    with pytest.raises(InputError, match=r"checkpoint-000001\.h5: no readable checkpoint"):
        store.latest()


def test_a_damaged_newest_checkpoint_gives_way_to_an_older_one(tmp_path: Path) -> None:
    store = CheckpointStore(tmp_path)
    older = store.save({"x": 1.0}, {"step": 1})
    newest = store.save({"x": 2.0}, {"step": 2})
    newest.write_bytes(newest.read_bytes()[:-500])
    found = store.latest()
    assert found is not None
    assert (found.path, found.state, found.damaged) == (older, {"x": 1.0}, (newest,))
    assert store.metadata() == {"step": 1}
