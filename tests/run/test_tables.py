"""Tables: exact, whole lines only, shortened on resume."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from knotfem import files
from knotfem.errors import InputError
from knotfem.run import columns
from knotfem.run.tables import Table, read_table, table_text, write_table


def row(value: float) -> dict[str, float]:
    return {"a_mm": value, "b_N": 2.0 * value}


@pytest.fixture
def table(tmp_path: Path) -> Table:
    table = Table(tmp_path / "t.csv", ("a_mm", "b_N"))
    table.extend(row(value / 3.0) for value in range(4))
    return table


def test_the_columns_that_scripts_rely_on() -> None:
    expected = "mapping_time, max_stretch, min_stretch, newton_iterations, wall_s"
    assert ", ".join(columns.TIE_COLUMNS) == expected
    expected = "time_s, displacement_mm, force_N, newton_iterations, contacts, max_penetration_mm, "
    expected += "kinetic_over_internal, wall_s"
    assert ", ".join(columns.FORCE_COLUMNS) == expected
    assert ", ".join(columns.TENSION_COLUMNS) == "displacement_mm, arclength_mm, s_over_L, tension_N, core_N, bulk_N"


def test_a_table_starts_with_its_header(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    assert Table(path, ("a_mm", "b_N")).rows == 0
    assert path.read_text() == "a_mm,b_N\n"
    assert {name: column.size for name, column in read_table(path).items()} == {"a_mm": 0, "b_N": 0}


@given(values=st.lists(st.floats(allow_nan=False), min_size=1, max_size=5))
def test_numbers_survive(tmp_path_factory: pytest.TempPathFactory, values: list[float]) -> None:
    path = tmp_path_factory.getbasetemp() / "survive.csv"
    path.unlink(missing_ok=True)
    table = Table(path, ("a_mm",))
    table.extend({"a_mm": np.float64(value)} for value in values)
    np.testing.assert_array_equal(read_table(path)["a_mm"], values)


def test_integers_and_text_stay_what_they_are(tmp_path: Path) -> None:
    table = Table(tmp_path / "t.csv", ("count", "rod"))
    table.append({"count": np.int64(3), "rod": "a, b"})
    assert table.path.read_text() == 'count,rod\n3,"a, b"\n'
    assert read_table(table.path)["rod"].tolist() == ["a, b"]


@pytest.mark.parametrize("column", ["step", "rod", "other", "state"])
def test_names_that_look_like_numbers_stay_text(tmp_path: Path, column: str) -> None:
    table = Table(tmp_path / "t.csv", ("a_mm", column))
    table.extend({"a_mm": 1.0, column: name} for name in ("1", "nan", "02"))
    read = read_table(table.path)
    assert read[column].tolist() == ["1", "nan", "02"]
    assert read["a_mm"].tolist() == [1.0, 1.0, 1.0]


def test_rows_go_on_after_reopening(table: Table) -> None:
    again = Table(table.path, table.columns)
    assert again.rows == 4
    again.append(row(7.0))
    assert read_table(table.path)["b_N"].tolist() == [0.0, 2.0 / 3.0, 4.0 / 3.0, 2.0, 14.0]


def test_resuming_drops_what_came_after_the_checkpoint(table: Table) -> None:
    before = table.path.read_text()
    table.extend(row(value) for value in (8.0, 9.0))
    again = Table(table.path, table.columns)
    again.keep(4)
    assert table.path.read_text() == before
    assert again.rows == 4


def test_a_crash_in_the_middle_of_a_line(table: Table) -> None:
    before = table.path.read_text()
    with table.path.open("a") as file:
        file.write("1.25,2")
    assert read_table(table.path)["a_mm"].size == 4
    assert Table(table.path, table.columns).rows == 4
    assert table.path.read_text() == before


def test_a_crash_in_the_middle_of_the_header(tmp_path: Path) -> None:
    (tmp_path / "t.csv").write_text("a_m")
    assert Table(tmp_path / "t.csv", ("a_mm", "b_N")).rows == 0
    assert (tmp_path / "t.csv").read_text() == "a_mm,b_N\n"


def test_missing_rows_are_not_made_up(table: Table) -> None:
    with pytest.raises(InputError, match="found 4; expected at least 5"):
        table.keep(5)


def test_a_full_disk_adds_no_row(table: Table, monkeypatch: pytest.MonkeyPatch) -> None:
    before = table.path.read_text()
    monkeypatch.setattr(files.os, "write", lambda descriptor, data: len(data) - 3)
    with pytest.raises(InputError, match="No space left"):
        table.append(row(5.0))
    assert (table.path.read_text(), table.rows) == (before, 4)


def test_other_columns_are_refused(table: Table) -> None:
    with pytest.raises(InputError, match="other columns"):
        Table(table.path, ("a_mm", "c_N"))


def test_rows_must_fit(table: Table) -> None:
    with pytest.raises(KeyError):
        table.append({"a_mm": 1.0})
    with pytest.raises(KeyError, match="c_N"):
        table.append({**row(1.0), "c_N": 1.0})
    assert read_table(table.path)["a_mm"].size == 4


def test_whole_tables(tmp_path: Path) -> None:
    columns = {"a_mm": np.array([0.1, 1e-300]), "b_N": np.array([1.0, -0.0])}
    write_table(tmp_path / "t.csv", columns)
    assert (tmp_path / "t.csv").read_text() == table_text(columns) == "a_mm,b_N\n0.1,1.0\n1e-300,-0.0\n"


def test_damaged_tables_are_refused(tmp_path: Path) -> None:
    path = tmp_path / "t.csv"
    with pytest.raises(InputError, match="cannot be read"):
        read_table(path)
    path.write_text("")
    with pytest.raises(InputError, match="empty"):
        read_table(path)
    path.write_text("a,b\n1,2\n3\n")
    with pytest.raises(InputError, match=r"line 3: a damaged table; found 1 fields; expected 2"):
        read_table(path)
    path.write_bytes(b"\xff\n")
    with pytest.raises(InputError, match="not a text file"):
        read_table(path)


def test_a_table_without_rows_takes_other_columns(tmp_path):
    """A run that goes on from another's tied knot may have effects of its own."""
    path = tmp_path / "force.csv"
    Table(path, ["a", "b"])
    table = Table(path, ["a", "b", "c"])
    table.append({"a": 1.0, "b": 2.0, "c": 3.0})
    assert path.read_text().splitlines()[0] == "a,b,c"
    with pytest.raises(InputError, match="other columns"):
        Table(path, ["a"])
