"""The diagnosis of each file in the repository: one line each, with its processor time.

``python -m support.diagnosed_files [EVERY [FIRST]]`` in tests diagnoses all files, or every
EVERY-th one: the corpus of other programs, files as users write them, and results of the field.
"""

import sys
import time
import tomllib
from collections.abc import Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

from corpus.files import files
from corpus.writing import HERE, Runs, text
from heyoka_bike.errors import BicycleError
from heyoka_bike.reference.load import load_reference
from heyoka_bike.scoring.diagnosis.diagnose import diagnose
from heyoka_bike.system.resources import data_folder


def named_files(folder: Path) -> Iterator[tuple[str, str, Path]]:
    """Yield name, expected diagnosis, and path of each file."""
    with open(HERE / "index.toml", "rb") as stream:
        index = {entry["name"]: entry["expected"] for entry in tomllib.load(stream)["file"]}
    runs = Runs()
    for file in files(runs.index):
        path = folder / f"{file.name}.txt"
        path.write_text(text(file, runs))
        yield file.name, index[file.name], path
    for path in sorted((HERE.parent / "scoring" / "written").iterdir()):
        yield path.name, "correct", path
    for path in sorted((data_folder() / "results").glob("*.txt.gz")):
        yield path.name, "correct", path


def main(every: int = 1, first: int = 0) -> None:
    reference = load_reference()
    with TemporaryDirectory() as folder:
        for name, expected, path in list(named_files(Path(folder)))[first::every]:
            begun = time.process_time()
            try:
                said = diagnose(str(path), reference).diagnosis
                told = f"{', '.join(f.code for f in said)} | {said[0].message[:100]}"
            except BicycleError as e:
                told = f"not scored | {e}"
            spent = time.process_time() - begun
            print(f"| {name} | {expected} | {told} | {spent:.1f} s |", flush=True)


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
