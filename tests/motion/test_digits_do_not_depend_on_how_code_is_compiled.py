"""The numbers do not depend on the settings of the compiler behind heyoka."""

import h5py
import heyoka as hy
import pytest

from heyoka_bike.cli import main
from heyoka_bike.reference.manifest import read_manifest

pytestmark = pytest.mark.proof

MANEUVER = """
[[maneuver]]
name = "a"
speed = "8"
roll_rate = "0.05"
duration = "0.04"
spacing = "0.01"
"""

# Compiler settings that differ from heyoka's: optimisation levels other than 3 (0 with MPFR), and
# registers as wide as the processor allows. Unrolled code at 70 digits takes minutes to compile and
# is left out.
VARIANTS = [{"opt_level": 0}, {"opt_level": 3, "force_avx512": True, "slp_vectorize": True}]


def made(folder):
    """Return hashes of a generated dataset's numbers: the certified ones, and the sensitivities."""
    (folder / "m.toml").write_text(MANEUVER)
    arguments = ["generate", "--maneuvers", str(folder / "m.toml"), "--out", str(folder / "set")]
    assert main(arguments) == 0
    with h5py.File(folder / "set" / "sensitivities.h5") as f:
        return read_manifest(folder / "set").content_sha256, f.attrs["content_sha256"]


@pytest.fixture(scope="module")
def expected(tmp_path_factory):
    """The hashes with the default settings."""
    return made(tmp_path_factory.mktemp("plain"))


@pytest.mark.parametrize("options", VARIANTS, ids=["plain", "wide"])
def test_compilation_changes_no_digit(options, expected, tmp_path, monkeypatch):
    plain, used = hy.taylor_adaptive, []

    def changed(*arguments, **given):
        used.append(options)
        return plain(*arguments, **{**given, **options})

    monkeypatch.setattr(hy, "taylor_adaptive", changed)
    # Generate the dataset in this process, where heyoka has the changed settings.
    assert made(tmp_path) == expected
    # The code is built once to find the end in binary64, and once for the motion.
    assert len(used) == 2
