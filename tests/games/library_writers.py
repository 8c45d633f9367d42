"""Writers of the drawings of `library_files`: libraries of Python, Octave and R, with options.

Each writer takes a random generator, a drawing and a path without a suffix, and returns the file.
"""

import csv
import gzip
import json
import subprocess
from dataclasses import dataclass, replace
from importlib.util import find_spec
from shutil import which

import numpy as np

TABLES = ("wide", "stacked", "long")
NESTED = ("wide", "stacked", "groups")
NAMES = ("none", "name", "name")
ROW = (*NAMES, "row")
ATTRIBUTES = (*NAMES, "attributes", "attributes")


@dataclass(frozen=True)
class Writer:
    """A writer, its layouts and unit styles, and the packages that it needs."""

    write: object
    layouts: tuple = TABLES
    units: tuple = NAMES
    needs: tuple = ()
    programs: tuple = ()

    @property
    def missing(self):
        """Return packages and programs that are not installed."""
        return [
            *(x for x in self.needs if find_spec(x) is None),
            *(x for x in self.programs if which(x) is None),
        ]


WRITERS = {}


def _writer(*needs, layouts=TABLES, units=NAMES, programs=()):
    def add(function):
        name = function.__name__.strip("_")
        WRITERS[name] = Writer(function, layouts, units, needs, programs)
        return function

    return add


def _pick(random, of):
    return of[int(random.integers(len(of)))]


def _plain(values):
    """Return values as Python objects."""
    if values.dtype.kind == "m":
        return (values / np.timedelta64(1, "s")).tolist()
    return values.tolist()


def _number(x):
    return repr(x) if isinstance(x, float) else str(x)


def _frame(random, drawn, table=None, *, levels=False):
    import pandas as pd

    table = drawn.table if table is None else table
    frame = pd.DataFrame({i: c.values for i, c in enumerate(table)})
    frame.columns = [c.name for c in table]
    if drawn.units_apart == "row":
        frame.columns = pd.MultiIndex.from_tuples([(c.name, c.unit) for c in table])
    elif levels:
        deep = max(len(c.path) for c in table)
        paths = [(*c.path, *[""] * (deep - len(c.path)))
                 for c in table]  # fmt: skip
        frame.columns = pd.MultiIndex.from_tuples(paths) if deep > 1 else [p[0] for p in paths]
    return frame


def _with_index(random, drawn, frame):
    """Use the times as the index in some drawings, if they are one column."""
    is_one = frame.columns.nlevels == 1 and drawn.time_name in list(frame.columns)
    name = drawn.time_name if is_one else None
    return frame.set_index(name) if name is not None and random.random() < 0.3 else frame


# Writers of text files


@_writer(layouts=TABLES, units=ROW)
def csv_module(random, drawn, path):
    mark = _pick(random, [",", ";", "\t", ","])
    decimal = "," if mark != "," and random.random() < 0.3 else "."
    quoting = _pick(random, [csv.QUOTE_MINIMAL, csv.QUOTE_ALL, csv.QUOTE_NONNUMERIC])
    end = _pick(random, ["\n", "\r\n"])
    encoding = _pick(random, ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
    file = path.with_suffix(".csv")
    with file.open("w", newline="", encoding=encoding, errors="replace") as f:
        if random.random() < 0.3:
            f.write(f"# bicycle, run of {drawn.motion}{end}")
        w = csv.writer(f, delimiter=mark, quoting=quoting, lineterminator=end)
        w.writerow([c.name for c in drawn.table])
        if drawn.units_apart == "row":
            around = _pick(random, ["{}", "[{}]", "({})"])
            w.writerow([around.format(c.unit) if c.unit else "" for c in drawn.table])
        for row in zip(*(_plain(c.values) for c in drawn.table), strict=True):
            cells = [_number(x).replace(".", decimal) if isinstance(x, float) else x for x in row]
            w.writerow(cells if quoting != csv.QUOTE_NONNUMERIC or decimal == "," else row)
    return file


@_writer("pandas", units=ROW)
def pandas_csv(random, drawn, path):
    frame = _with_index(random, drawn, _frame(random, drawn))
    mark = _pick(random, [",", ",", ";", "\t", " ", "|"])
    options = {"sep": mark, "decimal": "," if mark == ";" and random.random() < 0.5 else "."}
    options["index"] = frame.index.name is not None or random.random() < 0.5
    options["quoting"] = _pick(random, [csv.QUOTE_MINIMAL, csv.QUOTE_ALL, csv.QUOTE_NONNUMERIC])
    options["encoding"] = _pick(random, ["utf-8", "utf-8", "utf-16", "utf-8-sig"])
    options["lineterminator"] = _pick(random, ["\n", "\r\n"])
    options["na_rep"] = _pick(random, ["", "NaN"])
    packed = random.random() < 0.2
    file = path.with_suffix(".csv.gz" if packed else ".csv")
    frame.to_csv(file, **options)
    return file


@_writer("pandas", layouts=("wide", "stacked"))
def pandas_levels_csv(random, drawn, path):
    file = path.with_suffix(".csv")
    _frame(random, drawn, levels=True).to_csv(file, index=random.random() < 0.5)
    return file


@_writer("pandas", layouts=("groups",))
def pandas_concat_csv(random, drawn, path):
    import pandas as pd

    file = path.with_suffix(".csv")
    frames = {n: _frame(random, drawn, table) for n, table in drawn.tables.items()}
    if random.random() < 0.5:
        pd.concat(frames, names=["maneuver", "row"]).to_csv(file)
    else:
        frames = {f"maneuver_{n}": x for n, x in frames.items()}
        pd.concat(frames, axis=1).to_csv(file, index=random.random() < 0.5)
    return file


@_writer("pandas")
def pandas_string(random, drawn, path):
    import pandas as pd

    file = path.with_suffix(".txt")
    with pd.option_context("display.precision", 16):
        file.write_text(_frame(random, drawn).to_string(index=random.random() < 0.5), "utf-8")
    return file


@_writer("pandas", "tabulate", layouts=("wide",))
def pandas_markdown(random, drawn, path):
    file = path.with_suffix(".md")
    text = _frame(random, drawn).to_markdown(index=random.random() < 0.5, floatfmt=".17g")
    file.write_text(text, "utf-8")
    return file


@_writer("pandas", "jinja2", layouts=("wide",))
def pandas_latex(random, drawn, path):
    file = path.with_suffix(".tex")
    frame = _frame(random, drawn)
    file.write_text(frame.to_latex(index=False, float_format="%.17g", escape=True), "utf-8")
    return file


@_writer("pandas", "lxml", layouts=("wide",))
def pandas_other(random, drawn, path):
    kind = _pick(random, ["html", "xml", "pickle", "stata", "sql"])
    file, frame = path.with_suffix(f".{kind}"), _frame(random, drawn)
    if kind == "sql":
        import sqlite3

        with sqlite3.connect(file) as c:
            frame.iloc[:, :1].to_sql("r", c)
    elif kind == "xml":
        frame.rename(columns=lambda x: "".join(filter(str.isalnum, x)) or "x").to_xml(file)
    elif kind == "stata":
        frame = frame.select_dtypes("float")
        frame.columns = [f"v{i}" for i in range(frame.shape[1])]
        frame.to_stata(file)
    else:
        getattr(frame, f"to_{kind}")(file)
    return file


@_writer("polars")
def polars_csv(random, drawn, path):
    file = path.with_suffix(".csv")
    _polars(drawn).write_csv(
        file, separator=_pick(random, [",", ";", "\t"]),
        quote_style=_pick(random, ["necessary", "always", "non_numeric"]),
        include_bom=bool(random.random() < 0.2),
    )  # fmt: skip
    return file


@_writer("pyarrow")
def pyarrow_csv(random, drawn, path):
    from pyarrow import csv as arrow_csv

    file = path.with_suffix(".csv")
    options = arrow_csv.WriteOptions(delimiter=_pick(random, [",", ";", "\t"]))
    # The CSV format stores a time difference as a number of nanoseconds without a unit, so plain
    # numbers are written instead.
    plain = [replace(c, values=np.array(_plain(c.values))) if c.values.dtype.kind == "m" else c
             for c in drawn.table]  # fmt: skip
    arrow_csv.write_csv(_arrow(replace(drawn, tables={None: plain})), file, options)
    return file


@_writer(layouts=("wide",), units=ROW)
def numpy_savetxt(random, drawn, path):
    mark = _pick(random, [" ", ",", "\t", ";", ", "])
    table = [c for c in drawn.table if c.values.dtype.kind in "fiub"]
    heads = [c.name.replace(" ", "") if mark == " " else c.name for c in table]
    header = mark.join(heads)
    if drawn.units_apart == "row":
        header += "\n" + mark.join(f"[{c.unit}]" if c.unit else "-" for c in table)
    suffix = _pick(random, [".txt", ".dat.gz"])
    file = path.with_suffix(suffix)
    np.savetxt(file, np.column_stack([c.values for c in table]), delimiter=mark, header=header,
               fmt="%.17g", comments=_pick(random, ["# ", "", "% "]), encoding="utf-8")  # fmt: skip
    return file


@_writer(layouts=("wide",), units=("none",))
def rostopic_csv(random, drawn, path):
    """Write topics as ``rostopic echo -p`` does."""
    drawn.time_kind += " + %time"
    file = path.with_suffix(".csv")
    stamps = np.rint((drawn.time + 1.7e9) * 1e9).astype(np.int64)
    table = [c for c in drawn.table if c.values.dtype.kind in "fib"]
    heads = ["%time", *("field." + c.name.replace("/", ".").strip(".") for c in table)]
    rows = zip(stamps, *(_plain(c.values) for c in table), strict=True)
    file.write_text("\n".join([",".join(heads), *(",".join(map(str, row)) for row in rows)]) + "\n")
    return file


@_writer(layouts=("wide",), units=("none",))
def openmodelica_csv(random, drawn, path):
    file = path.with_suffix(".csv")
    table = [c for c in drawn.table if c.values.dtype.kind in "fib"]
    rows = zip(*(_plain(c.values) for c in table), strict=True)
    lines = [",".join(f'"{c.name}"' for c in table), *(",".join(map(_number, r)) for r in rows)]
    file.write_text("\n".join(lines) + "\n")
    return file


# Writers of JSON


@_writer("pandas")
def pandas_json(random, drawn, path):
    orient = _pick(random, ["split", "columns", "index", "records", "lines", "table", "values"])
    frame = _with_index(random, drawn, _frame(random, drawn)).copy()
    if orient in ("columns", "index") and not frame.index.is_unique:
        frame = frame.reset_index()
    for i, c in enumerate(frame.columns):
        if frame.iloc[:, i].dtype.kind == "m":
            frame = frame.assign(**{c: frame.iloc[:, i].dt.total_seconds()})
    is_lines = orient == "lines"
    suffix = ".jsonl" if is_lines else ".json"
    file = path.with_suffix(suffix + (".gz" if random.random() < 0.2 else ""))
    frame.to_json(file, orient="records" if is_lines else orient, lines=is_lines,
                  double_precision=15)  # fmt: skip
    return file


def _nested(columns, make=dict):
    """Put the columns of one table into the groups of their paths."""
    found = make()
    columns = [replace(c, path=(*c.path[:-1], c.path[-1].replace(" / ", " in "))) for c in columns]
    for c in columns:
        at = found
        for step in c.path[:-1]:
            at = at.setdefault(step, make())
            if not isinstance(at, dict):
                return {x.name: x for x in columns}
        if isinstance(at.get(c.path[-1]), dict):
            return {x.name: x for x in columns}
        at[c.path[-1]] = c
    return found


def _leaves(x, leaf):
    return {k: _leaves(y, leaf) for k, y in x.items()} if isinstance(x, dict) else leaf(x)


@_writer(layouts=NESTED, units=ATTRIBUTES)
def json_module(random, drawn, path):
    def columns(table):
        def leaf(c):
            values = _plain(c.values)
            values = [None if x != x else x for x in values]
            return {"unit": c.unit, "values": values} if c.unit else values

        return _leaves(_nested(table), leaf)

    def records(table):
        nested = _nested(table)
        return [_leaves(nested, lambda c, i=i: _plain(c.values)[i])
                for i in range(len(table[0].values))]  # fmt: skip

    kinds = [columns] if drawn.units_apart == "attributes" else [columns, records]
    kind = _pick(random, kinds)
    if None in drawn.tables:
        document = kind(drawn.table)
        document = {"results": document} if random.random() < 0.2 else document
    elif random.random() < 0.5:
        document = {f"maneuver_{n}": kind(t) for n, t in drawn.tables.items()}
    else:
        drawn.is_told = True
        document = [{"maneuver": int(n), **columns(t)} for n, t in drawn.tables.items()]
    file = path.with_suffix(".json")
    file.write_text(json.dumps(document, indent=_pick(random, [None, 1]),
                               ensure_ascii=bool(random.random() < 0.5)), "utf-8")  # fmt: skip
    return file


@_writer("polars")
def polars_json(random, drawn, path):
    frame = _polars(drawn)
    if random.random() < 0.5:
        file = path.with_suffix(".json")
        frame.write_json(file)
    else:
        file = path.with_suffix(".ndjson")
        frame.write_ndjson(file)
    return file


# Writers of binary columns


def _polars(drawn, table=None):
    import polars as pl

    found = {}
    for c in drawn.table if table is None else table:
        values = _plain(c.values) if c.values.dtype.kind in "mO" else c.values
        found[c.name] = pl.Series(c.name, values)
    return pl.DataFrame(found)


def _arrow(drawn, *, structs=False):
    import pyarrow as pa

    def leaf(c):
        return pa.array(_plain(c.values) if c.values.dtype.kind == "O" else c.values)

    if not structs:
        return pa.table([leaf(c) for c in drawn.table], names=[c.name for c in drawn.table])

    def struct(x):
        if not isinstance(x, dict):
            return leaf(x)
        return pa.StructArray.from_arrays([struct(y) for y in x.values()], names=[*x])

    nested = _nested(drawn.table)
    return pa.table([struct(x) for x in nested.values()], names=[*nested])


@_writer("pandas", "pyarrow", units=ROW)
def pandas_parquet(random, drawn, path):
    frame = _with_index(random, drawn, _frame(random, drawn))
    if random.random() < 0.5:
        file = path.with_suffix(".parquet")
        frame.to_parquet(file, compression=_pick(random, ["snappy", "gzip", "zstd", None]),
                         index=_pick(random, [None, True]))  # fmt: skip
    else:
        file = path.with_suffix(".feather")
        if frame.index.name is not None:
            frame = frame.reset_index()
        if frame.columns.nlevels > 1:
            frame.columns = [f"{n} [{u}]" if u else n for n, u in frame.columns]
        frame.to_feather(file, compression=_pick(random, ["lz4", "zstd", "uncompressed"]))
    return file


@_writer("pandas", "pyarrow", layouts=("wide", "stacked"))
def pandas_levels_parquet(random, drawn, path):
    file = path.with_suffix(".parquet")
    _frame(random, drawn, levels=True).to_parquet(file)
    return file


@_writer("pyarrow", layouts=("wide", "stacked"))
def pyarrow_structs(random, drawn, path):
    from pyarrow import feather, parquet

    table = _arrow(drawn, structs=True)
    if random.random() < 0.6:
        file = path.with_suffix(".parquet")
        parquet.write_table(table, file)
    else:
        file = path.with_suffix(".arrow")
        feather.write_feather(table, file)
    return file


@_writer("pandas", "pyarrow", layouts=("wide",), units=("none",))
def pandas_dicts_parquet(random, drawn, path):
    import pandas as pd

    nested = _nested([c for c in drawn.table if c.values.dtype.kind in "fib"])

    def column(x):
        if not isinstance(x, dict):
            return x.values
        inner = {k: column(y) for k, y in x.items()}
        return [dict(zip(inner, row, strict=True)) for row in zip(*inner.values(), strict=True)]

    file = path.with_suffix(".parquet")
    pd.DataFrame({k: column(x) for k, x in nested.items()}).to_parquet(file)
    return file


@_writer("pyarrow")
def pyarrow_files(random, drawn, path):
    import pyarrow as pa
    from pyarrow import feather, orc, parquet

    table, kind = _arrow(drawn), _pick(random, ["parquet", "ipc", "stream", "feather1", "orc"])
    file = path.with_suffix(f".{kind}")
    if kind == "parquet":
        parquet.write_table(table, file, row_group_size=40, use_dictionary=random.random() < 0.5)
    elif kind == "feather1":
        table = table.select([f.name for f in table.schema if not pa.types.is_duration(f.type)])
        feather.write_feather(table, file, version=1)
    elif kind == "orc":
        table = table.select([f.name for f in table.schema if not pa.types.is_duration(f.type)])
        orc.write_table(table, file)
    else:
        with pa.OSFile(str(file), "wb") as f:
            make = pa.ipc.new_file if kind == "ipc" else pa.ipc.new_stream
            with make(f, table.schema) as w:
                w.write_table(table, max_chunksize=40)
    return file


@_writer("polars")
def polars_files(random, drawn, path):
    frame, kind = _polars(drawn), _pick(random, ["parquet", "arrow", "stream", "avro"])
    file = path.with_suffix(f".{kind}")
    if kind == "parquet":
        frame.write_parquet(file, compression=_pick(random, ["zstd", "lz4", "uncompressed"]))
    elif kind == "arrow":
        frame.write_ipc(file, compression=_pick(random, ["uncompressed", "lz4", "zstd"]))
    elif kind == "stream":
        frame.write_ipc_stream(file)
    else:
        frame.write_avro(file)
    return file


@_writer("polars", "pyarrow", layouts=("wide",))
def polars_structs(random, drawn, path):
    import polars as pl

    def column(name, x):
        if not isinstance(x, dict):
            values = _plain(x.values) if x.values.dtype.kind in "mO" else x.values
            return pl.Series(name, values)
        return pl.DataFrame([column(k, y) for k, y in x.items()]).to_struct(name)

    frame = pl.DataFrame([column(k, x) for k, x in _nested(drawn.table).items()])
    if random.random() < 0.6:
        file = path.with_suffix(".parquet")
        frame.write_parquet(file)
    else:
        file = path.with_suffix(".ndjson")
        frame.write_ndjson(file)
    return file


# Writers of spreadsheets


@_writer("pandas", "openpyxl", "xlsxwriter", layouts=("wide", "stacked", "groups"), units=ROW)
def pandas_excel(random, drawn, path):
    import pandas as pd

    file = path.with_suffix(".xlsx")
    options = {"index": bool(random.random() < 0.4 or drawn.units_apart == "row")}
    options |= _pick(random, [{}, {}, {"startrow": 3, "startcol": 2}])
    with pd.ExcelWriter(file, engine=_pick(random, ["openpyxl", "xlsxwriter"])) as w:
        for n, table in drawn.tables.items():
            name = "Sheet1" if n is None else f"maneuver_{n}"
            # A spreadsheet stores a time difference as a number of days without a unit, so plain
            # numbers are written instead.
            plain = [replace(c, values=np.array(_plain(c.values))) if c.values.dtype.kind == "m"
                     else c for c in table]  # fmt: skip
            _frame(random, drawn, plain).to_excel(w, sheet_name=name, **options)
    return file


@_writer("openpyxl", layouts=("wide", "stacked", "groups"), units=ROW)
def openpyxl_sheet(random, drawn, path):
    from openpyxl import Workbook

    book, file = Workbook(), path.with_suffix(".xlsx")
    book.remove(book.active)
    titled, noted = random.random() < 0.3, random.random() < 0.3
    for n, table in drawn.tables.items():
        sheet = book.create_sheet("Data" if n is None else f"Maneuver {n}")
        if titled:
            sheet.append(["Bicycle, simulated"])
            sheet.append([])
        sheet.append([c.name for c in table])
        if drawn.units_apart == "row":
            sheet.append([c.unit or None for c in table])
        for row in zip(*(_plain(c.values) for c in table), strict=True):
            sheet.append([None if x != x else x for x in row])
    if noted:
        book.create_sheet("notes").append(["made by a program"])
    book.save(file)
    return file


# Writers of HDF5 and netCDF


@_writer("pandas", "tables", layouts=("wide", "stacked"))
def pandas_hdf(random, drawn, path):
    file = path.with_suffix(".h5")
    frame = _with_index(random, drawn, _frame(random, drawn))
    kind = _pick(random, ["fixed", "table"])
    options = {"complevel": _pick(random, [0, 5])}
    if kind == "table" and random.random() < 0.4:
        some = [x for x in frame.columns if x.isidentifier()][:3]
        options["data_columns"] = True if random.random() < 0.3 else some
    frame.to_hdf(file, key=_pick(random, ["df", "bike", "results/run"]), format=kind, **options)
    return file


@_writer(layouts=NESTED, units=ATTRIBUTES)
def h5py_groups(random, drawn, path):
    import h5py

    file = path.with_suffix(".h5")
    options = _pick(random, [{}, {"compression": "gzip"}, {"chunks": True, "shuffle": True}])
    kind = np.float32 if drawn.digits == 7 else np.float64
    attribute = _pick(random, ["units", "unit"])

    def put(group, nested):
        for name, c in nested.items():
            if isinstance(c, dict):
                put(group.create_group(name), c)
                continue
            values = c.values
            values = np.array(_plain(values)) if values.dtype.kind == "m" else values
            if values.dtype.kind == "O":
                group.create_dataset(name, data=[str(x) for x in values])
                continue
            values = values.astype(kind) if c.key else values
            d = group.create_dataset(name, data=values, **options)
            if c.unit:
                d.attrs[attribute] = c.unit if random.random() < 0.7 else np.bytes_(c.unit.encode())

    outer = _pick(random, ["", "run", "results/a"])
    with h5py.File(file, "w") as f:
        for n, table in drawn.tables.items():
            top = "/".join(x for x in (outer, "" if n is None else f"maneuver_{n}") if x)
            # A name that contains a slash creates groups.
            put(f.require_group(top) if top else f, _nested(table))
    return file


@_writer(layouts=("wide", "stacked", "groups"))
def h5py_compound(random, drawn, path):
    import h5py

    file = path.with_suffix(".h5")
    with h5py.File(file, "w") as f:
        for n, table in drawn.tables.items():
            some = [c for c in table if c.values.dtype.kind in "fib"]
            kinds = [(c.name, "i1" if c.values.dtype.kind == "b" else c.values.dtype) for c in some]
            rows = np.zeros(len(some[0].values), kinds)
            for c in some:
                rows[c.name] = c.values
            f.create_dataset("results" if n is None else f"maneuver_{n}", data=rows)
    return file


@_writer("tables", layouts=("wide", "stacked"))
def pytables(random, drawn, path):
    import tables

    file = path.with_suffix(".h5")
    some = [c for c in drawn.table if c.values.dtype.kind in "fib"]
    rows = np.zeros(len(some[0].values), [(c.name.replace("/", "."), c.values.dtype) for c in some])
    for c in some:
        rows[c.name.replace("/", ".")] = c.values
    with tables.open_file(file, "w") as f:
        f.create_table("/", "log", rows)
    return file


@_writer("xarray", "netCDF4", "h5netcdf", "scipy", layouts=("wide", "axis"), units=ATTRIBUTES)
def xarray_netcdf(random, drawn, path):
    import xarray as xr

    engine, kind = _pick(random, [
        ("netcdf4", "NETCDF4"), ("netcdf4", "NETCDF3_CLASSIC"), ("netcdf4", "NETCDF3_64BIT"),
        ("h5netcdf", "NETCDF4"), ("scipy", "NETCDF3_64BIT"), ("netcdf4", "NETCDF4_CLASSIC"),
    ])  # fmt: skip
    values = {}
    some = [c for c in drawn.table if c.values.dtype.kind in "fi"]
    (time,) = [c for c in some if c.path[-1] == drawn.time_name] or [None]
    as_coordinate = time is not None and random.random() < 0.7
    along = time.name.replace("/", "_") if as_coordinate else "row"
    for c in some:
        name = c.name.replace("/", "_")
        data = c.values.astype(np.int32) if c.values.dtype.kind == "i" and (
            "3" in kind and c.values.max() < 2**31) else c.values.astype(float)  # fmt: skip
        values[name] = (along, data, {"units": c.unit} if c.unit else {})
    data = xr.Dataset(values)
    data = data.set_coords(along) if as_coordinate else data
    file = path.with_suffix(".nc")
    data.to_netcdf(file, engine=engine, format=kind)
    return file


@_writer("xarray", "netCDF4", "h5netcdf", "scipy", layouts=("groups",), units=ATTRIBUTES)
def xarray_axis(random, drawn, path):
    import xarray as xr

    numbers = list(drawn.tables)
    columns = [c for c in drawn.tables[numbers[0]] if c.key]
    values = {}
    for c in columns:
        each = [next(x for x in t if x.name == c.name).values for t in drawn.tables.values()]
        name = c.name.replace("/", "_")
        values[name] = (("maneuver", "time"), np.stack(each), {"units": c.unit} if c.unit else {})
    # xarray converts values that have a unit of time to dates and time differences. So the time is
    # in seconds, without a unit.
    data = xr.Dataset(values, coords={"time": drawn.time, "maneuver": numbers})
    drawn.time_kind = "s"
    if random.random() < 0.4:
        data = data.transpose()
    file = path.with_suffix(".nc")
    data.to_netcdf(file, engine=_pick(random, ["netcdf4", "h5netcdf", "scipy"]))
    return file


@_writer("xarray", "zarr", layouts=("wide",))
def xarray_zarr(random, drawn, path):
    import xarray as xr

    values = {c.name.replace("/", "_"): ("row", c.values) for c in drawn.table
              if c.values.dtype.kind in "fi"}  # fmt: skip
    file = path.with_suffix(".zarr")
    xr.Dataset(values).to_zarr(file)
    return file


@_writer("netCDF4", layouts=("wide", "groups"), units=ATTRIBUTES)
def netcdf4_groups(random, drawn, path):
    from netCDF4 import Dataset

    file = path.with_suffix(".nc")
    with Dataset(file, "w") as f:
        f.createDimension("time", None if random.random() < 0.5 else len(drawn.time))
        for n, table in drawn.tables.items():
            group = f if n is None else f.createGroup(f"maneuver_{n}")
            for c in table:
                if c.values.dtype.kind not in "fi":
                    continue
                v = group.createVariable(c.name.replace("/", "_"), c.values.dtype, ("time",),
                                         zlib=bool(random.random() < 0.5))  # fmt: skip
                v[:] = c.values
                if c.unit:
                    v.units = c.unit
    return file


# Writers of NumPy and MATLAB files


@_writer(layouts=("wide", "stacked"))
def numpy_savez(random, drawn, path):
    some = [c for c in drawn.table if c.values.dtype.kind in "fib"]
    if random.random() < 0.4:
        file = path.with_suffix(".npy")
        rows = np.zeros(len(some[0].values), [(c.name, c.values.dtype) for c in some])
        for c in some:
            rows[c.name] = c.values
        np.save(file, rows)
        return file
    file = path.with_suffix(".npz")
    save = np.savez_compressed if random.random() < 0.5 else np.savez
    save(file, **{c.name: c.values for c in some})
    return file


def _identifiers(table):
    """Return numeric columns with unique names, changed as MATLAB and R change invalid names."""
    found, letters = {}, {"φ": "phi", "δ": "delta", "°": "deg", "º": "deg"}
    for c in table:
        plain = "".join(letters.get(x, x) for x in c.name)
        name = "".join(x if x.isascii() and x.isalnum() else "_" for x in plain).strip("_")
        if c.values.dtype.kind in "fib" and name and name[0].isalpha() and name not in found:
            found[name] = c.values
    return found


@_writer("scipy", layouts=("wide", "stacked", "groups"))
def scipy_savemat(random, drawn, path):
    from scipy.io import savemat

    tables = {n: _identifiers(t) for n, t in drawn.tables.items()}
    file = path.with_suffix(".mat")
    options = {"oned_as": _pick(random, ["row", "column"])}
    if None not in tables:
        document = {f"maneuver_{n}": t for n, t in tables.items()}
        if random.random() < 0.3:
            document = {"results": document}
    else:
        document = tables[None]
        if random.random() < 0.3:
            document = {"bike": document}
        elif random.random() < 0.3 and all(len(x) < 32 for x in document):
            options["format"] = "4"
            document = {k: v.astype(float) for k, v in document.items()}
    if options.get("format") != "4":
        options |= {"do_compression": bool(random.random() < 0.5), "long_field_names": True}
    savemat(file, document, **options)
    return file


@_writer("hdf5storage", layouts=("wide", "stacked", "groups"))
def hdf5storage_mat(random, drawn, path):
    import hdf5storage

    tables = {n: _identifiers(t) for n, t in drawn.tables.items()}
    file = path.with_suffix(".mat")
    document = tables[None] if None in tables else {f"maneuver_{n}": t for n, t in tables.items()}
    if random.random() < 0.3:
        document = {"bike": document}
    hdf5storage.savemat(str(file), document, format="7.3",
                        oned_as=_pick(random, ["row", "column"]),
                        store_python_metadata=False, matlab_compatible=True)  # fmt: skip
    return file


@_writer("scipy", layouts=("wide",), units=("none",))
def dymola_mat(random, drawn, path):
    from scipy.io import savemat

    some = [c for c in drawn.table if c.values.dtype.kind in "fi"]
    drawn.time_kind, t = "s", drawn.time
    some = [c for c in some if c.key]
    names = ["Time" if random.random() < 0.5 else "time", "p.mass", *(c.name for c in some)]
    width = max(map(len, names))
    text = [x.ljust(width) for x in names]
    info = [[0, 1, 0, -1], [1, 2, 0, -1], *([2, i + 2, 0, -1] for i in range(len(some)))]
    lines = np.vstack([t, *(c.values for c in some)])
    how = _pick(random, ["binTrans", "binNormal"])
    turn = np.transpose if how == "binTrans" else np.asarray
    file = path.with_suffix(".mat")
    savemat(file, {
        "Aclass": np.array(["Atrajectory", "1.1        ", "           ", how.ljust(11)]),
        "name": np.array(text if how == "binNormal" else [*map("".join, zip(*text, strict=True))]),
        "description": np.array([" "]),
        "dataInfo": turn(np.array(info, dtype=np.int32)),
        "data_1": turn(np.array([[0.0, 87.0], [t[-1], 87.0]])),
        "data_2": lines if how == "binTrans" else lines.T,
    }, format="4")  # fmt: skip
    return file


# Writers that run other programs


def _run(*command, folder):
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(done.stderr[-500:])


@_writer(layouts=("wide", "stacked", "groups"), programs=("octave-cli",))
def octave(random, drawn, path):
    """Write by one of Octave's ways to save, a structure or variables."""
    tables = {n: _identifiers(t) for n, t in drawn.tables.items()}
    lines = []
    for n, columns in tables.items():
        for name, values in columns.items():
            np.savetxt(path.parent / f"{path.name}-{len(lines)}", values.astype(float), "%.17g")
            of = "s." if n is None else f"s.maneuver_{n}."
            lines.append(f"{of}{name} = load('{path.name}-{len(lines)}');")
    kind = _pick(random, ["-v7", "-v6", "-v4", "-hdf5", "-text", "json", "dlm"])
    whole = random.random() < 0.5 and kind != "-v4"
    suffix = {"-hdf5": ".h5", "-text": ".txt", "json": ".json", "dlm": ".csv"}.get(kind, ".mat")
    file = path.with_suffix(suffix)
    if kind == "json":
        lines.append(f"f = fopen('{file.name}', 'w'); fprintf(f, '%s', jsonencode(s)); fclose(f);")
    elif kind == "dlm" and None in tables:
        heads = ",".join(tables[None])
        lines.append(f"f = fopen('{file.name}', 'w'); fprintf(f, '{heads}\\n'); fclose(f);")
        lines.append(f"dlmwrite('{file.name}', cell2mat(struct2cell(s)'), '-append', "
                     "'precision', '%.17g');")  # fmt: skip
    else:
        kind = "-v7" if kind == "dlm" else kind
        of = "'s'" if whole else "'-struct', 's'"
        if kind == "-v4":
            names = next(iter(tables.values())) if None in tables else ()
            if not names or any(len(x) > 18 for x in names):
                kind = "-v6"
        lines.append(f"save('{kind}', '{file.name}', {of});")
    script = path.with_suffix(".m")
    script.write_text("\n".join(lines))
    _run("octave-cli", "--no-init-file", "-q", script.name, folder=path.parent)
    return file


@_writer(programs=("Rscript",))
def r_tables(random, drawn, path):
    """Write a data frame by ``write.csv``, ``write.table``, ``readr`` or ``dput``."""
    source = path.with_name(f"{path.name}-source.csv")
    with source.open("w", newline="", encoding="utf-8") as f:
        w = csv.writer(f)
        w.writerow([c.name for c in drawn.table])
        for row in zip(*(_plain(c.values) for c in drawn.table), strict=True):
            w.writerow([_number(x) for x in row])
    names = _pick(random, ["TRUE", "FALSE"])
    file = path.with_suffix(".txt")
    calls = {
        "write.csv(d, f)": 3, "write.csv(d, f, row.names=FALSE)": 3, "write.table(d, f)": 3,
        "write.csv2(d, f, row.names=FALSE)": 2, "write.csv(d, f, quote=FALSE)": 1,
        'write.table(d, f, sep="\\t", quote=FALSE, row.names=FALSE)': 2,
        'write.table(d, f, sep="\\t", col.names=NA)': 1, "sink(f); print(d); sink()": 1,
        "dput(d, f)": 1, "saveRDS(d, f)": 1, "dump('d', f)": 1, "save(d, file=f)": 1,
    }  # fmt: skip
    call = _pick(random, [x for x, n in calls.items() for _ in range(n)])
    drawn.style += f" {call}"
    script = path.with_suffix(".R")
    script.write_text(
        f'options(digits=15); d <- read.csv("{source.name}", check.names={names}, '
        f'encoding="UTF-8"); f <- "{file.name}"; {call}'
    )
    _run("Rscript", "--vanilla", script.name, folder=path.parent)
    return file


def packed(random, file):
    """Return the file, or a copy compressed by gzip."""
    if random.random() < 0.1 and file.is_file() and file.suffix != ".gz":
        other = file.with_suffix(f"{file.suffix}.gz")
        other.write_bytes(gzip.compress(file.read_bytes(), 1))
        return other
    return file
