"""Rare layouts of containers are read like the plain layout, or refused by name."""

import json
import pickle
import sys

import h5py
import numpy as np
import pytest

from generators.published_columns import published_columns
from heyoka_bike import load_reference, read_results, score
from heyoka_bike.bicycle.columns import BENCHMARK_COLUMNS as KEYS
from heyoka_bike.errors import InputError, MissingPackageError


def columns(number):
    return published_columns(load_reference(), number, every=20)


def lists(number, rows=slice(None)):
    return {key: x[rows].tolist() for key, x in columns(number).items()}


def table(number, rows=slice(None)):
    return np.column_stack(list(columns(number).values()))[rows].tolist()


def scored(path, content):
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return score(path)


DOCUMENTS = {
    "tables, one in another": lambda: [table(n) for n in (1, 2, 3)],
    "tables of other lengths": lambda: [table(1), table(2, slice(9)), table(3)],
    "objects without a number": lambda: [lists(n) for n in (1, 2, 3)],
    "objects that say one number": lambda: [{"maneuver": "2"} | lists(n) for n in (1, 2, 3)],
    "objects whose names are words": lambda: [
        {"name": "slow", "unit": "SI"} | lists(1), {"id": "fast"} | lists(2),
    ],
    "one object in a list": lambda: [lists(2)],
}  # fmt: skip


@pytest.mark.parametrize("name", DOCUMENTS)
def test_json_in_whatever_nesting(name, tmp_path):
    document = DOCUMENTS[name]()
    report = scored(tmp_path / "a.json", document)
    assert len(report.maneuvers) == len(document)
    assert all(c.as_understood.measures.scd > 12 for m in report.maneuvers for c in m.columns)


@pytest.mark.parametrize("document", [[[], []], {"rows": [[], []]}, {"a": [1, [2]]}])
def test_json_without_a_table(document, tmp_path):
    with pytest.raises(InputError, match="found JSON without a table"):
        scored(tmp_path / "a.json", document)


def test_times_of_each_maneuver_beside_arrays_of_all(tmp_path):
    """Arrays of maneuvers by rows, including the times."""
    each = [columns(n) for n in (1, 2, 3)]
    path = tmp_path / "a.npz"
    np.savez(path, **{key: np.stack([c[key] for c in each]) for key in each[0]})
    report = score(path)
    assert report.is_right
    assert len(report.maneuvers) == 3


def test_a_maneuver_without_a_table_beside_others(tmp_path):
    path = tmp_path / "a.h5"
    with h5py.File(path, "w") as file:
        file.create_group("maneuver_1").update(columns(1))
        file.create_group("maneuver_2").update({"x": [1.0, 2.0], "y": [3.0, 4.0]})
    with pytest.raises(InputError, match=r"x.*y"):
        read_results(path)


def test_columns_in_groups_without_any_time(tmp_path):
    path = tmp_path / "a.h5"
    known = columns(1)
    with h5py.File(path, "w") as file:
        for group, key in (("state", "roll_angle"), ("energy", "kinetic_energy")):
            file[f"{group}/{key}"] = known[key]
    with pytest.raises(InputError, match="expected"):
        read_results(path)


class TestPandasInHdf5:
    """`to_hdf` files written by hand: a table with blocks whose names are in a pickle."""

    @staticmethod
    def written(path, names, index="f8"):
        known = columns(2)
        kind = np.dtype([("index", index), ("values_block_0", "f8", (len(KEYS),))])
        rows = np.zeros(len(known["time"]), kind)
        rows["index"] = known["time"]
        rows["values_block_0"] = np.column_stack([known[key] for key in KEYS])
        with h5py.File(path, "w") as file:
            group = file.create_group("bike")
            group.attrs["pandas_type"] = np.bytes_("frame_table")
            data = group.create_dataset("table", data=rows)
            data.attrs["values_block_0_kind"] = np.void(names)
            data.attrs["index_kind"] = np.bytes_("float")

    def test_names_of_a_block(self, tmp_path):
        path = tmp_path / "a.h5"
        self.written(path, pickle.dumps(list(KEYS), 0))
        assert score(path).is_right

    @pytest.mark.parametrize("names", [pickle.dumps(["roll_angle"], 0), b"no pickle", b"X"])
    def test_names_that_are_not_those_of_its_columns(self, names, tmp_path):
        path = tmp_path / "a.h5"
        self.written(path, names)
        with pytest.raises(InputError, match="expected"):
            read_results(path)


def test_a_closed_standard_input_is_said(monkeypatch):
    monkeypatch.setattr(sys, "stdin", None)
    with pytest.raises(InputError, match="closed"):
        read_results("-")


def test_a_format_that_needs_a_package_says_which(monkeypatch, tmp_path):
    path = tmp_path / "a.parquet"
    path.write_bytes(b"PAR1" + bytes(100) + b"PAR1")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(MissingPackageError, match="pyarrow"):
        read_results(path)


def test_two_columns_of_a_quantity_with_other_gaps(tmp_path):
    """The two columns have equal values, but one value is missing in one of them."""
    known = columns(2)
    other = np.degrees(known["roll_angle"])
    other[7] = np.nan
    path = tmp_path / "a.npz"
    np.savez(path, **known, **{"roll_angle [deg]": other})
    report = score(path)
    assert not report.is_whole
    assert "roll_angle [deg]" in {x.name for x in report.not_compared}


class TestMatlab:
    """Variables with the names of a Modelica trajectory or a Simulink log."""

    @staticmethod
    def read(path, variables):
        pytest.importorskip("scipy.io").savemat(path, variables)
        return score(path)

    def test_columns_beside_a_class_of_another_kind(self, tmp_path):
        others = {"Aclass": "bicycle", "name": "mine", "dataInfo": np.zeros((2, 4))}
        assert self.read(tmp_path / "a.mat", columns(2) | others).is_right

    def test_a_trajectory_without_its_values(self, tmp_path):
        kinds = np.array(["Atrajectory", "1.1", "", "binNormal"])
        variables = {"Aclass": kinds, "name": np.array(["time"]), "dataInfo": np.zeros((1, 4))}
        with pytest.raises(InputError, match="a trajectory without its names and values"):
            self.read(tmp_path / "a.mat", variables)

    def test_a_log_whose_signals_have_other_lengths(self, tmp_path):
        known = columns(2)
        signals = [
            {"values": known["roll_angle"], "label": "a"},
            {"values": known["steer_angle"][:-3], "label": "b"},
        ]
        with pytest.raises(InputError, match="expected"):
            self.read(tmp_path / "a.mat", {"log": {"time": known["time"], "signals": signals}})
