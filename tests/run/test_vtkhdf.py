import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import h5py
import numpy as np
import pytest

from knotfem.errors import InputError
from knotfem.run.frames import read_frame, read_mesh, read_times
from knotfem.run.vtkhdf import VtkHdfSeries

if TYPE_CHECKING:
    from vtkmodules.vtkCommonDataModel import vtkUnstructuredGrid

REFERENCE = np.array([[x, y, z] for z in range(4) for y in range(2) for x in range(2)], dtype=float)
HEXES = np.array([[0, 1, 3, 2, 4, 5, 7, 6]]) + 4 * np.arange(3)[:, None]
FULL_DISK = """
import resource, sys
import numpy as np
from knotfem.errors import InputError
from knotfem.run.vtkhdf import VtkHdfSeries
rng = np.random.default_rng(0)
points = rng.normal(size=(20000, 3))
series = VtkHdfSeries.create(sys.argv[1], points, np.arange(8)[None, :])
series.append(0.0, points)
resource.setrlimit(resource.RLIMIT_FSIZE, (2_300_000, 2_300_000))
try:
    for time in range(1, 9):
        series.append(time, points + time)
except InputError as error:
    print(error)
    print(len(series.times))
"""
ENDLESS = """
import sys
import numpy as np
from knotfem.run.vtkhdf import VtkHdfSeries
points = np.random.default_rng(0).normal(size=(2000, 3))
series = VtkHdfSeries.create(sys.argv[1], points, np.arange(8)[None, :])
time = 0.0
while True:
    series.append(time, points + time, cell_data={"pressure": np.array([time])})
    time += 1.0
    print(time, flush=True)
"""


def stress(step: int) -> np.ndarray:
    return np.arange(18.0).reshape(3, 6) + 100 * step


def shifted(by: float) -> np.ndarray:
    return REFERENCE + np.array([0.0, by, 0.0])


def fill(series: VtkHdfSeries, steps: range) -> None:
    for i in steps:
        moved = shifted(0.1 * i)
        pressure = np.linspace(0, i, len(REFERENCE))
        series.append(
            0.25 * i,
            moved,
            point_data={"contact_pressure": pressure},
            cell_data={"stress": stress(i), "largest_principal_strain": np.arange(3.0) + i},
        )


@pytest.fixture
def path(tmp_path) -> Path:
    with VtkHdfSeries.create(
        tmp_path / "results.vtkhdf", REFERENCE, HEXES, point_data={"arclength": REFERENCE[:, 2]}
    ) as series:
        fill(series, range(5))
    return tmp_path / "results.vtkhdf"


def values(file: h5py.File, name: str) -> np.ndarray:
    """All values of a data set."""
    found = file[name]
    assert isinstance(found, h5py.Dataset)
    return np.asarray(found[()])


def vtk_steps(path: Path) -> list[tuple[float, "vtkUnstructuredGrid"]]:
    from vtkmodules.vtkCommonExecutionModel import vtkStreamingDemandDrivenPipeline
    from vtkmodules.vtkIOHDF import vtkHDFReader

    reader = vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    steps = []
    for t in times:
        reader.UpdateTimeStep(t)
        copy = reader.GetOutput().NewInstance()
        copy.DeepCopy(reader.GetOutput())
        steps.append((t, copy))
    return steps


def test_vtk_reads_times_moving_points_and_arrays(path):
    from vtkmodules.util.numpy_support import vtk_to_numpy

    steps = vtk_steps(path)
    assert [t for t, _ in steps] == [0.0, 0.25, 0.5, 0.75, 1.0]
    for i, (_, grid) in enumerate(steps):
        moved = shifted(0.1 * i)
        assert grid.GetNumberOfCells() == 3
        assert {grid.GetCellType(c) for c in range(3)} == {12}
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetCells().GetConnectivityArray()).reshape(-1, 8), HEXES)
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPoints().GetData()), moved)
        points = {
            name: vtk_to_numpy(grid.GetPointData().GetArray(name)) for name in ("displacement", "contact_pressure")
        }
        np.testing.assert_allclose(points["displacement"], moved - REFERENCE, atol=1e-7)
        np.testing.assert_allclose(points["contact_pressure"], np.linspace(0, i, len(REFERENCE)), rtol=1e-6)
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetPointData().GetArray("arclength")), REFERENCE[:, 2])
        np.testing.assert_array_equal(vtk_to_numpy(grid.GetCellData().GetArray("stress")), stress(i))
        strain = vtk_to_numpy(grid.GetCellData().GetArray("largest_principal_strain"))
        np.testing.assert_array_equal(strain, np.arange(3.0) + i)
        volume = sum(grid.GetCell(c).GetBounds()[5] - grid.GetCell(c).GetBounds()[4] for c in range(3))
        assert volume == pytest.approx(3.0)


def test_frames_read_back(path):
    np.testing.assert_array_equal(read_times(path), [0.0, 0.25, 0.5, 0.75, 1.0])
    reference, hexes = read_mesh(path)
    np.testing.assert_array_equal(reference, REFERENCE)
    np.testing.assert_array_equal(hexes, HEXES)
    frame = read_frame(path, 2)
    assert frame.time == 0.5
    np.testing.assert_array_equal(frame.points, shifted(0.2))
    np.testing.assert_array_equal(frame.cell_data["stress"], stress(2))
    np.testing.assert_array_equal(frame.point_data["arclength"], REFERENCE[:, 2])
    assert read_frame(path).time == 1.0


def test_positions_keep_their_last_bit(tmp_path):
    points = REFERENCE + np.random.default_rng(3).normal(size=REFERENCE.shape)
    with VtkHdfSeries.create(tmp_path / "a.vtkhdf", REFERENCE, HEXES) as series:
        series.append(0.0, points)
    np.testing.assert_array_equal(read_frame(tmp_path / "a.vtkhdf").points, points)


def test_a_caller_may_reuse_its_arrays(tmp_path):
    points = REFERENCE.copy()
    with VtkHdfSeries.create(tmp_path / "a.vtkhdf", REFERENCE, HEXES) as series:
        for i in range(4):
            points[:] = REFERENCE + i
            series.append(i, points)
    for i in range(4):
        np.testing.assert_array_equal(read_frame(tmp_path / "a.vtkhdf", i).points, REFERENCE + i)


def test_truncated_and_continued_is_as_never_stopped(path, tmp_path):
    with VtkHdfSeries(path) as series:
        series.truncate(2)
        assert len(read_times(path)) == 2
        fill(series, range(2, 5))
    with VtkHdfSeries.create(
        tmp_path / "b.vtkhdf", REFERENCE, HEXES, point_data={"arclength": REFERENCE[:, 2]}
    ) as series:
        fill(series, range(5))
    with h5py.File(path) as one, h5py.File(tmp_path / "b.vtkhdf") as other:
        names: list[str] = []
        other.visit(names.append)
        assert "VTKHDF/Steps/PointDataOffsets/displacement" in names
        for name in names:
            if isinstance(other[name], h5py.Dataset):
                np.testing.assert_array_equal(values(one, name), values(other, name), err_msg=name)
    assert len(vtk_steps(path)) == 5


def test_truncated_to_nothing_starts_again(path):
    with VtkHdfSeries(path) as series:
        series.truncate(0)
        fill(series, range(1))
        series.truncate(0)
        for i in range(2):
            series.append(i, REFERENCE, cell_data={"tension": np.zeros(3)})
    assert len(vtk_steps(path)) == 2


def test_no_hidden_files_are_left(path):
    assert [p.name for p in path.parent.iterdir()] == ["results.vtkhdf"]


def test_without_hard_links_nothing_changes(tmp_path, monkeypatch):
    def refuse(*_: object) -> None:
        raise OSError("no links here")

    monkeypatch.setattr(os, "link", refuse)
    with VtkHdfSeries.create(tmp_path / "a.vtkhdf", REFERENCE, HEXES) as series:
        fill(series, range(4))
    assert len(vtk_steps(tmp_path / "a.vtkhdf")) == 4


@pytest.mark.parametrize("delay", [0.0, 0.004, 0.009, 0.015])
def test_a_kill_loses_no_finished_step(tmp_path, delay):
    path = tmp_path / "killed.vtkhdf"
    with subprocess.Popen([sys.executable, "-c", ENDLESS, str(path)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for _ in range(4):
            process.stdout.readline()
        time.sleep(delay)
        process.send_signal(signal.SIGKILL)
        finished = 4 + len(process.stdout.readlines())
    times = read_times(path)
    assert len(times) in (finished, finished + 1)
    np.testing.assert_array_equal(times, np.arange(len(times)))
    reference, _ = read_mesh(path)
    np.testing.assert_array_equal(read_frame(path).points, reference + times[-1])
    with VtkHdfSeries(path) as series:
        series.append(1e3, reference, cell_data={"pressure": np.zeros(1)})
    assert len(vtk_steps(path)) == len(times) + 1
    assert [p.name for p in tmp_path.iterdir()] == ["killed.vtkhdf"]


def test_a_full_disk_gives_one_message_and_keeps_the_steps(tmp_path):
    path = tmp_path / "full.vtkhdf"
    done = subprocess.run([sys.executable, "-c", FULL_DISK, str(path)], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
    message, steps = done.stdout.splitlines()
    assert message.startswith(f"{path}: cannot be written (")
    assert len(read_times(path)) == int(steps) > 0
    assert [p.name for p in tmp_path.iterdir()] == ["full.vtkhdf"]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"points": REFERENCE[1:]}, "points have shape"),
        ({"cell_data": {"stress": stress(0)[:2], "largest_principal_strain": np.zeros(3)}}, "stress has 2 rows"),
        ({"cell_data": {"stress": stress(0)[:, :5], "largest_principal_strain": np.zeros(3)}}, "components"),
        ({"cell_data": {"stress": stress(0)}}, r"expected \["),
        ({"time": 1.0}, "does not follow"),
        ({"point_data": {"contact_pressure": np.zeros(16), "arclength": np.zeros(16)}}, r"expected \["),
    ],
)
def test_a_step_that_does_not_fit_is_refused_and_leaves_the_file_alone(path, change, message):
    step = {
        "time": 9.0,
        "points": REFERENCE,
        "point_data": {"contact_pressure": np.zeros(len(REFERENCE))},
        "cell_data": {"stress": stress(0), "largest_principal_strain": np.zeros(3)},
    }
    before = path.read_bytes()
    with VtkHdfSeries(path) as series:
        with pytest.raises(ValueError, match=message):
            series.append(**{**step, **change})
        assert path.read_bytes() == before
        series.append(**step)
    assert len(read_times(path)) == 6


def test_wrong_files_are_refused(path, tmp_path):
    with pytest.raises(InputError, match="no such results file"):
        read_times(tmp_path / "absent.vtkhdf")
    (tmp_path / "text.vtkhdf").write_text("text")
    with pytest.raises(InputError, match="not an HDF5 file"):
        VtkHdfSeries(tmp_path / "text.vtkhdf")
    with h5py.File(tmp_path / "other.vtkhdf", "w") as file:
        file["x"] = 1
    with pytest.raises(InputError, match="not a time series"):
        read_frame(tmp_path / "other.vtkhdf")
    with pytest.raises(InputError, match="found 5; expected one of 5 steps"):
        read_frame(path, 5)
    with pytest.raises(InputError, match="cannot be written"):
        VtkHdfSeries.create(tmp_path / "absent" / "a.vtkhdf", REFERENCE, HEXES)
    with pytest.raises(ValueError, match="6 steps asked for"):
        VtkHdfSeries(path).truncate(6)
    with pytest.raises(ValueError, match="arclength has 2 rows"):
        VtkHdfSeries.create(tmp_path / "a.vtkhdf", REFERENCE, HEXES, point_data={"arclength": np.zeros(2)})


def test_quadrilaterals_are_stored_as_such(tmp_path):
    quads = np.array([[0, 1, 3, 2], [2, 3, 7, 6]])
    with VtkHdfSeries.create(tmp_path / "a.vtkhdf", REFERENCE[:8], quads) as series:
        series.append(0.0, REFERENCE[:8], cell_data={"tension": np.array([1.0, 2.0])})
    with h5py.File(tmp_path / "a.vtkhdf") as file:
        assert values(file, "VTKHDF/Types").tolist() == [9, 9]
        assert values(file, "VTKHDF/Offsets").tolist() == [0, 4, 8]
    assert read_mesh(tmp_path / "a.vtkhdf")[1].tolist() == quads.tolist()
