"""Write the files of this folder, with programs that the tests do not need.

    python -m venv v && v/bin/pip install pandas pyarrow polars xlsxwriter openpyxl xarray \\
        netCDF4 h5netcdf hdf5storage tables
    v/bin/python write.py ../../../reference/uncontrolled-bicycle.txt && octave-cli write.m

Each contains the same rows: every 91st row of the published text (all 25 columns, 17 digits).
"""

import json
import sys
from pathlib import Path

import hdf5storage
import numpy as np
import pandas as pd
import polars as pl
import xarray as xr
from scipy.io import savemat

KEYS = [
    "roll_angle", "roll_rate", "forward_speed", "potential_energy", "kinetic_energy",
    "mechanical_energy", "steer_angle", "steer_rate",
]  # fmt: skip

here = Path(__file__).parent
x = np.loadtxt(sys.argv[1])[::91]
np.savetxt(here / "rows.txt", x, "%.17g")
t = x[:, 0]
tables = {m: x[:, [0, *range(8 * m - 7, 8 * m + 1)]] for m in (1, 2, 3)}
names = ["time", *(f"m{m}_{key}" for m in tables for key in KEYS)]
wide = pd.DataFrame(x, columns=names)
each = {m: pd.DataFrame(table, columns=["time", *KEYS]) for m, table in tables.items()}
long = pd.concat([f.assign(maneuver=m) for m, f in each.items()], ignore_index=True)
named = long.assign(maneuver=[f"maneuver_{m}" for m in long.maneuver])

# Files written by pandas
for orient in ("split", "columns", "index", "records", "values", "table"):
    wide.to_json(here / f"pandas-{orient}.json", orient=orient, double_precision=15)
long.to_json(here / "pandas-long.jsonl", orient="records", lines=True, double_precision=15)
named.to_csv(here / "pandas-named.csv")
pd.concat(each, names=["maneuver", "step"]).to_csv(here / "pandas-concat.csv")
wide.to_csv(here / "pandas-index.tsv", sep="\t")
wide.to_excel(here / "pandas.xlsx")
wide.to_excel(here / "xlsxwriter.xlsx", engine="xlsxwriter", index=False, startrow=3, startcol=2)
with pd.ExcelWriter(here / "sheets.xlsx") as w:
    pd.DataFrame({"note": ["made by hand"]}).to_excel(w, sheet_name="notes")
    for m, frame in each.items():
        frame.to_excel(w, sheet_name=f"Maneuver {m}", index=False)
wide.to_parquet(here / "pandas.parquet")
named.astype({"maneuver": "category"}).to_parquet(here / "category.parquet")
wide.to_feather(here / "pandas.feather")

# Files written by pandas with names that are paths, in an order that differs from the benchmark's
order = [names[0], *sorted(names[1:], key=lambda name: name[::-1])]
moved = wide[order]
levels = moved.copy()
levels.columns = pd.MultiIndex.from_tuples(
    [("", "time"), *((name[:2], name[3:]) for name in order[1:])]
)
levels.to_csv(here / "pandas-levels.csv", index=False)
levels.to_parquet(here / "pandas-levels.parquet")
moved.to_hdf(here / "pandas-fixed.h5", key="df", format="fixed")
moved.to_hdf(here / "pandas-table.h5", key="df", format="table")
moved.set_index("time").to_hdf(here / "pandas-index.h5", key="df", format="fixed")
moved.to_csv(here / "pandas-unnamed.csv", index_label=False)
moved.rename(columns=lambda name: name.replace("_", ".", 1)).to_csv(here / "paths.csv", index=False)

# A trajectory in the format of Dymola and OpenModelica, with a parameter and an additional variable
variables = [*order, "m1.rear.speed"]
lines = np.column_stack([moved.to_numpy(), -moved.to_numpy()[:, 1]]).T
text = [name.ljust(max(map(len, variables))) for name in ["p.mass", *variables]]
info = [[1, 2, 0, -1], [0, 1, 0, -1], *([2, i, 0, -1] for i in range(2, len(variables) + 1))]
for how in ("binTrans", "binNormal"):
    turn = np.transpose if how == "binTrans" else np.asarray
    savemat(here / f"trajectory-{how}.mat", {
        "Aclass": np.array(["Atrajectory", "1.1        ", "           ", how.ljust(11)]),
        "name": np.array(text if how == "binNormal" else [*map("".join, zip(*text, strict=True))]),
        "description": np.array([" "]),
        "dataInfo": turn(np.array(info, dtype=np.int32)),
        "data_1": turn(np.array([[0.0, 87.0], [9.1, 87.0]])),
        "data_2": lines if how == "binTrans" else lines.T,
    }, format="4")  # fmt: skip

# Files written by polars
pl.from_pandas(long).write_parquet(here / "polars-long.parquet")
pl.from_pandas(wide).write_ipc(here / "polars.arrow")
pl.from_pandas(wide).write_json(here / "polars.json")
pl.from_pandas(long).write_ndjson(here / "polars.ndjson")

# Files written by xarray with netCDF's own library, with h5netcdf and with SciPy
columns = {key: np.stack([tables[m][:, 1 + i] for m in tables]) for i, key in enumerate(KEYS)}
data = xr.Dataset(
    {key: (("maneuver", "time"), c) for key, c in columns.items()},
    coords={"time": t, "maneuver": [1, 2, 3]},
)
data.to_netcdf(here / "xarray-4.nc", engine="netcdf4")
data.transpose().drop_vars("maneuver").to_netcdf(here / "xarray-turned.nc", engine="netcdf4")
data.to_netcdf(here / "xarray-h5.nc", engine="h5netcdf")
data.to_netcdf(here / "xarray-3.nc", engine="scipy")
data.to_dataframe().to_csv(here / "xarray.csv")

# Files written by SciPy and hdf5storage, in the form that Simulink's blocks Outport and To
# Workspace log
column = t[:, None]
fields = [(name, "O") for name in ("values", "dimensions", "label", "blockName")]
signals = np.zeros((1, 24), dtype=fields)
for j in range(24):
    signals[0, j] = (x[:, [j + 1]], 1.0, names[j + 1], f"bicycle/Out{j + 1}")
unnamed = signals.copy()
unnamed["label"] = ""
whole = {"values": x[:, 1:], "dimensions": 24.0, "label": "", "blockName": "bicycle/Scope"}
logs = {
    "arrays": {"tout": column, "yout": x[:, 1:], "xout": x[:, 1:] + 1},
    "structure": {"simout": {"time": column, "signals": whole, "blockName": "bicycle/Scope"}},
    "signals": {"yout": {"time": column, "signals": unnamed}},
    "labels": {"yout": {"time": np.zeros((0, 0)), "signals": signals}, "tout": column},
    "cube": {"results": np.stack([*tables.values()], 2)},
}
for name, log in logs.items():
    savemat(here / f"scipy-{name}.mat", log)
    # In these files the labels are texts of MATLAB's own type.
    hdf5storage.savemat(
        str(here / f"hdf5storage-{name}.mat"), log, format="7.3", oned_as="column",
        store_python_metadata=False, matlab_compatible=True,
    )  # fmt: skip

# Files written by json
documents = {
    "columns": {name: wide[name].tolist() for name in names},
    "heading": [names, *x.tolist()],
    "maneuvers": {
        "program": "mine",
        "steps": [1, 2, 3],
        "results": {
            "maneuvers": [
                {"maneuver": m, **{name: f[name].tolist() for name in f}} for m, f in each.items()
            ]
        },
    },
    "units": {name: {"unit": "SI", "values": wide[name].tolist()} for name in names},
    "axis": {"time": t.tolist()} | {key: c.tolist() for key, c in columns.items()},
    "solution": {"t": t.tolist(), "y": x[:, 1:].T.tolist()},
}
for name, document in documents.items():
    (here / f"json-{name}.json").write_text(json.dumps(document, indent=1))
