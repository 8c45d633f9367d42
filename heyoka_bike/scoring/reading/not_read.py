"""Unsupported formats: how to recognise them by their first bytes, and how to convert them."""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

_PANDAS = "in pandas: frame.to_csv('results.csv', index=False)"
_FRAME = f"{_PANDAS}; in polars: frame.write_csv('results.csv')"
_R = "in R: write.csv(d, 'results.csv', row.names=FALSE)"
_ROS = "in PlotJuggler: export the curves as CSV, a column for each joint"
_SPREADSHEETS = (".xls", ".xlsx", ".xlsm", ".xlsb", ".ods")


@dataclass(frozen=True, slots=True)
class NotRead:
    """A format that is recognised but not supported.

    Attributes
    ----------
    found
        Name of the format in messages.
    begins
        A regular expression for the first bytes of a file.
    instead
        How to convert a file to a readable format, a command if there is one; may be empty.
    """

    found: str
    begins: str
    instead: str = ""


NOT_READ = (
    NotRead("a spreadsheet", r"\xd0\xcf\x11\xe0", "save it as xlsx or CSV"),
    NotRead("a picture", r"\x89PNG|\xff\xd8\xff|GIF8"),
    NotRead("a PDF document", r"%PDF"),
    NotRead(
        "a database", r"SQLite format 3",
        "sqlite3 -csv -header FILE 'SELECT * FROM table' > results.csv",
    ),
    NotRead("a bzip2 file", r"BZh[1-9]1AY&SY", "bunzip2 FILE"),
    NotRead("an xz file", r"\xfd7zXZ", "unxz FILE"),
    NotRead("a zstd file", r"\x28\xb5\x2f\xfd", "unzstd FILE"),
    NotRead("a 7z file", r"7z\xbc\xaf", "7z x FILE"),
    NotRead("a pickle", r"\x80[\x02-\x05]", _PANDAS),
    NotRead(
        "a TDMS file of LabVIEW", r"TDS[mh]",
        "in Python: nptdms.TdmsFile(FILE).as_dataframe().to_csv('results.csv')",
    ),
    NotRead(
        "an MDF measurement file", r"(?:MDF|UnFinMF) ",
        "in Python: asammdf.MDF(FILE).to_dataframe().to_csv('results.csv')",
    ),
    NotRead("a ROS bag", r"#ROSBAG|\x89MCAP0", _ROS),
    NotRead("ROS messages", r"(?:---\s+)?header:\s*\n\s+(?:seq|stamp):", _ROS),
    NotRead(
        "ROS's JointState messages",
        # JointState messages in JSON, in the columns that rostopic writes, and in rows whose cells
        # contain lists.
        r"\s*[\[{](?=[\s\S]*\"name\"\s*:\s*\[\s*\")(?=[\s\S]*\"position\"\s*:\s*\[)"
        r"|[^\n]*\bname0\b[^\n]*\bposition0\b"
        r"|[^\n]*\bposition\b[^\n]*\n[^\n]*\[\s*[-'\"0-9]",
        _ROS,
    ),
    NotRead("an HDF4 file", r"\x0e\x03\x13\x01", "h4toh5 FILE results.h5"),
    NotRead(
        "a file of SPSS", r"\$FL[23]", "in pandas: pd.read_spss(FILE).to_csv('results.csv')"
    ),
    NotRead(
        "a file of SAS", r"\x00{12}\xc2\xea\x81\x60|HEADER RECORD\*{7}",
        "in pandas: pd.read_sas(FILE).to_csv('results.csv')",
    ),
    NotRead("an lz4 file", r"\x04\x22\x4d\x18", "unlz4 FILE"),
    NotRead("an Avro file", r"Obj\x01", _FRAME),
    NotRead("an ORC file", r"ORC[\s\S]{0,60}?[\x00-\x08]", _FRAME),
    NotRead("Feather of version 1", r"FEA1\x00", "in Python: feather.write_feather(table, FILE)"),
    NotRead(
        "a file of Stata", r"<stata_dta>|[\x6e-\x77]\x01\x01\x00",
        "in Stata: export delimited results.csv",
    ),
    NotRead("R's saved objects", r"RD[XAB][23]\n|[XAB]\n\x00\x00\x00", _R),
    NotRead("R's dput", r"(?:[\w.`\"]+\s*<-\s*)?structure\(list\(", _R),
    NotRead("a dictionary as Python prints it", r"\s*\{'", "in Python: json.dump(d, file)"),
    NotRead("a table of Markdown", r"\s*\|[^\n]*\|[ \t]*\r?\n[ \t]*\|[-:| \t]+\|", _FRAME),
    NotRead("a table of LaTeX", r"\s*\\begin\{(?:table|tabular|longtable)", _FRAME),
    NotRead("HTML", r"\s*<(?i:!doctype|html|table|body)\b", _FRAME),
    NotRead("XML", r"\s*<\?xml", _FRAME),
    NotRead(
        "fields separated by |",
        r"[^\n]*\|[^\n]*\n(?:[^\n]*\n)?(?:[^\n|]*\|)*?\"?[-+0-9.][^\n|]*\|",
        "in pandas: frame.to_csv('results.csv', sep=',')",
    ),
)  # fmt: skip
"""Formats that are recognised but not read, in the order in which they are tested."""

SHORTENED = frozenset({"...", "\u2026", ".."})
"""Signs in place of rows or columns that are omitted from a printed table."""

PRINT_ALL = f"a table is shortened for printing; {_PANDAS}; in NumPy: np.savetxt('results.txt', x)"
"""The message about a table with such signs."""

_PATTERNS = tuple((x, re.compile(x.begins.encode("latin-1"))) for x in NOT_READ)


def not_read(head: bytes) -> NotRead | None:
    """Return the unsupported format that the first bytes of a file show; None if none is known."""
    return next((x for x, pattern in _PATTERNS if pattern.match(head)), None)


def is_called_spreadsheet(suffix: str) -> bool:
    """True if the suffix of a file name is that of a spreadsheet."""
    return suffix in _SPREADSHEETS


def folder(path: Path) -> NotRead:
    """Return the message parts for a folder: what kind of folder it is, and how to convert it."""
    is_zarr = any((path / name).exists() for name in ("zarr.json", ".zgroup", ".zarray"))
    if is_zarr:
        return NotRead("a folder of Zarr", "", "in xarray: data.to_netcdf('results.nc')")
    return NotRead("a directory", "")
