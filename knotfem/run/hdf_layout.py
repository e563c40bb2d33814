"""Where the parts of a transient UnstructuredGrid lie in a VTKHDF file (version 2.0)."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from knotfem.run.field_meanings import FIELDS
from knotfem.run.frames import Frame
from knotfem.types import Array, Index

_CELL_TYPES = {8: 12, 27: 29, 4: 9}
"""VTK's number of the cell with so many points: hexahedron, triquadratic hexahedron, quadrilateral."""
DISPLACEMENT = "displacement_mm"
"""Of the reported end, one value a step."""
_PACKED: dict[str, Any] = {"compression": "gzip", "compression_opts": 1, "shuffle": True}


def write_mesh(file: Any, reference: Array, cells: Index) -> None:
    """Lay out an empty series.

    Args:
        file: an empty h5py file.
        reference: positions from which displacements count, in mm, shape (N, 3).
        cells: points of each cell in VTK order, shape (E, 8) or (E, 27) for hexahedra, (E, 4) for quadrilaterals.
    """
    import h5py

    root = file.create_group("VTKHDF")
    root.attrs["Version"] = np.array([2, 0])
    kind = b"UnstructuredGrid"
    root.attrs.create("Type", kind, dtype=h5py.string_dtype("ascii", len(kind)))
    root.create_dataset("NumberOfPoints", data=np.array([len(reference)]))
    root.create_dataset("NumberOfCells", data=np.array([len(cells)]))
    root.create_dataset("NumberOfConnectivityIds", data=np.array([cells.size]))
    root.create_dataset("Connectivity", data=cells.astype(np.int64).ravel(), **_PACKED)
    root.create_dataset("Offsets", data=cells.shape[1] * np.arange(len(cells) + 1), **_PACKED)
    root.create_dataset("Types", data=np.full(len(cells), _CELL_TYPES[cells.shape[1]], dtype=np.uint8), **_PACKED)
    root.create_dataset("Points", (0, 3), np.float64, maxshape=(None, 3), chunks=(len(reference), 3), **_PACKED)
    steps = root.create_group("Steps")
    steps.attrs["NSteps"] = 0
    steps.create_dataset("Values", (0,), np.float64, maxshape=(None,), chunks=(1024,))
    for name in ("PartOffsets", "NumberOfParts", "PointOffsets"):
        steps.create_dataset(name, (0,), np.int64, maxshape=(None,), chunks=(1024,))
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        steps.create_dataset(name, (0, 1), np.int64, maxshape=(None, 1), chunks=(1024, 1))
    for name in ("PointData", "CellData", "FieldData"):
        root.create_group(name)
        steps.create_group(f"{name}Offsets")
    _new_offsets(steps["FieldDataOffsets"], DISPLACEMENT)
    moved = root["FieldData"].create_dataset(DISPLACEMENT, (0,), np.float64, maxshape=(None,), chunks=(1024,))
    _describe(moved, DISPLACEMENT)
    file.create_dataset("knotfem/reference", data=reference, **_PACKED)


def write_constant(root: Any, kind: str, name: str, values: NDArray[Any]) -> None:
    """Store an array that all steps share.

    Raises:
        ValueError: it does not fit the mesh.
    """
    rows = int(root["NumberOfPoints" if kind == "PointData" else "NumberOfCells"][0])
    if len(values) != rows:
        raise ValueError(f"{name} has {len(values)} rows, the mesh has {rows}")
    _describe(root[kind].create_dataset(name, data=as_stored(values), **_PACKED), name)
    _new_offsets(root["Steps"][f"{kind}Offsets"], name)


def stored_bytes(frame: Frame) -> int:
    """Bytes of a step before compression, displacement included."""
    arrays = (frame.points, frame.points, *frame.point_data.values(), *frame.cell_data.values())
    return sum(values.nbytes for values in arrays)


def append_frame(root: Any, frame: Frame) -> None:
    """Append a step.

    Raises:
        ValueError: the arrays do not fit the mesh or the steps before.
    """
    reference = root.file["knotfem/reference"]
    points, cells = int(root["NumberOfPoints"][0]), int(root["NumberOfCells"][0])
    if frame.points.shape != (points, 3):
        raise ValueError(f"points have shape {frame.points.shape}, the mesh has {(points, 3)}")
    steps = root["Steps"]
    count = int(steps.attrs["NSteps"])
    displacement = frame.points - reference[:]
    for kind, rows, arrays in (
        ("PointData", points, {"displacement": displacement, **frame.point_data}),
        ("CellData", cells, frame.cell_data),
    ):
        data, offsets = root[kind], steps[f"{kind}Offsets"]
        constant = {name for name in data if data[name].maxshape[0] is not None}
        before = set(data) - constant if count else set(arrays) - constant
        if before != set(arrays):
            raise ValueError(f"this step has the {kind} {sorted(arrays)}, expected {sorted(before)}")
        for name, values in arrays.items():
            _append_array(data, offsets, name, as_stored(values), rows, count)
        for name in constant:
            _extend(offsets[name], [0])
    if "FieldData" in root:  # files of older versions have none
        _extend(root["FieldData"][DISPLACEMENT], [frame.displacement])
        _extend(steps["FieldDataOffsets"][DISPLACEMENT], [count])
    _extend(root["Points"], frame.points)
    _extend(steps["PointOffsets"], [count * points])
    for name, value in (("Values", [frame.time]), ("PartOffsets", [0]), ("NumberOfParts", [1])):
        _extend(steps[name], value)
    for name in ("CellOffsets", "ConnectivityIdOffsets"):
        _extend(steps[name], [[0]])
    steps.attrs["NSteps"] = count + 1


def _append_array(data: Any, offsets: Any, name: str, values: NDArray[Any], rows: int, step: int) -> None:
    if len(values) != rows:
        raise ValueError(f"{name} has {len(values)} rows, the mesh has {rows}")
    if name not in data:
        tail = values.shape[1:]
        made = data.create_dataset(
            name, (0, *tail), values.dtype, maxshape=(None, *tail), chunks=values.shape, **_PACKED
        )
        _describe(made, name)
        _new_offsets(offsets, name)
    if data[name].shape[1:] != values.shape[1:]:
        raise ValueError(f"{name} has shape {values.shape}, the steps before have {data[name].shape[1:]} components")
    _extend(data[name], values)
    _extend(offsets[name], [step * rows])


def truncate(root: Any, count: int) -> None:
    """Keep the first `count` steps; with none left, the next step may bring other arrays."""
    steps = root["Steps"]
    steps.attrs["NSteps"] = count
    points, cells = int(root["NumberOfPoints"][0]), int(root["NumberOfCells"][0])
    for name in ("Values", "PartOffsets", "NumberOfParts", "PointOffsets", "CellOffsets", "ConnectivityIdOffsets"):
        steps[name].resize(count, axis=0)
    root["Points"].resize(count * points, axis=0)
    if "FieldData" in root:
        root["FieldData"][DISPLACEMENT].resize(count, axis=0)
        steps["FieldDataOffsets"][DISPLACEMENT].resize(count, axis=0)
    for kind, rows in (("PointData", points), ("CellData", cells)):
        data, offsets = root[kind], steps[f"{kind}Offsets"]
        for name in list(data):
            if data[name].maxshape[0] is not None:
                offsets[name].resize(count, axis=0)
            elif count:
                offsets[name].resize(count, axis=0)
                data[name].resize(count * rows, axis=0)
            else:
                del data[name], offsets[name]


def _describe(dataset: Any, name: str) -> None:
    """Say in attributes what a field is, and its unit."""
    found = FIELDS.get(name)
    if found is not None:
        parts = {"description": found.text, "unit": found.unit, "components": found.components}
        dataset.attrs.update({key: text for key, text in parts.items() if text})


def _new_offsets(group: Any, name: str) -> None:
    group.create_dataset(name, (0,), np.int64, maxshape=(None,), chunks=(1024,))


def _extend(dataset: Any, rows: Any) -> None:
    start = len(dataset)
    dataset.resize(start + len(rows), axis=0)
    dataset[start:] = rows


def as_stored(values: NDArray[Any]) -> NDArray[Any]:
    """A copy in the type that is stored: float32 for fields, integers as they are."""
    values = np.asarray(values)
    return values.astype(np.float32) if values.dtype.kind == "f" else values.copy()
