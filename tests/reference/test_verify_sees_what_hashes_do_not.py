"""Each check of `heyoka-bike verify` finds its damage, even if the manifest matches.

Each damage is made in a copy of a small dataset, and its manifest and content_sha256 are then
updated. So only the named check, and others that use the same number, can fail.
"""

import json
import shutil
from fractions import Fraction
from functools import lru_cache

import h5py
import numpy as np
import pytest

from generators.made_sets import accept, accept_numbers, make, manifest
from heyoka_bike.cli import main
from heyoka_bike.reference.description import describe
from heyoka_bike.reference.layout import CARD, CRATE, content_sha256
from heyoka_bike.reference.manifest import DATASET_VERSION, MANIFEST, read_manifest
from heyoka_bike.reference.verification.verify import check_files, read_content, verify

pytestmark = pytest.mark.proof

HDF5, CANDIDATE, CERTIFICATE = "uncontrolled-bicycle.h5", "candidate.h5", "certificate.json"
TEXT, TEXT_50 = "uncontrolled-bicycle.txt", "uncontrolled-bicycle-50digits.txt"
ULP = 2.0**-52


@pytest.fixture(scope="module")
def whole(made_once):
    """A dataset with one maneuver of 11 rows and several dense segments."""
    return made_once("whole-set", lambda place: make(place, ("0.2", "0.02"))) / "set"


@pytest.fixture
def copy(whole, tmp_path):
    return shutil.copytree(whole, tmp_path / "copy")


def outcomes(folder):
    """Return all check results, computed once for equal files."""
    return _outcomes(folder, frozenset((p.name, p.read_bytes()) for p in folder.iterdir()))


@lru_cache(maxsize=1)
def _outcomes(folder, files):
    return verify(folder).checks


def failed(folder):
    """Return failed checks, with their files."""
    return {(c.check, c.file) for c in outcomes(folder) if c.passed is False}


def message(folder, check):
    return next(c.message for c in outcomes(folder) if c.check == check and c.passed is False)


def change(folder, name, index, new, *, in_line=True):
    """Change a number of the HDF5 file; `new` is a function of the old number."""
    with h5py.File(folder / HDF5, "r+") as f:
        item = f[f"maneuver_1/{name}"]
        item[index] = new(item[index])
        if in_line:
            accept_numbers(folder, f)
    accept(folder)


def change_text(folder, name, row, field, new):
    path = folder / name
    lines = [line.split(" ") for line in path.read_text().splitlines()]
    lines[row][field] = new(lines[row][field])
    path.write_text("\n".join(" ".join(line) for line in lines) + "\n")
    accept(folder)


def change_json(folder, new):
    """Change the certificate, in its canonical form."""
    path = folder / CERTIFICATE
    document = json.loads(path.read_text())
    new(document)
    path.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")
    accept(folder)


def other_digit(text, place):
    """Return the number with another digit at a place after its point."""
    i = text.index(".") + place
    return text[:i] + str((int(text[i]) + 5) % 10) + text[i + 1 :]


def test_the_whole_set_passes(whole):
    assert all(c.passed for c in outcomes(whole))


def test_a_card_and_a_crate_that_say_something_else(folder, tmp_path):
    """Only a published dataset of this version has a card and a crate."""
    copy = shutil.copytree(folder, tmp_path / "copy")
    manifest(copy, dataset_version=DATASET_VERSION)

    def wrong():
        accept(copy)
        set_manifest, data, _ = check_files(copy)
        _, checks = read_content(copy, set_manifest, data)
        return {c.file: c.message for c in checks if c.file in (CARD, CRATE) and not c.passed}

    for name, data in describe(read_manifest(copy)).items():
        (copy / name).write_bytes(data)
    assert wrong() == {}
    for name, old, new in ((CARD, b"32 digits", b"33 digits"), (CRATE, b"MIT", b"BSD")):
        data = (copy / name).read_bytes()
        assert old in data
        (copy / name).write_bytes(data.replace(old, new))
    assert wrong() == dict.fromkeys((CARD, CRATE), "does not follow from manifest.json")


def test_a_card_in_a_set_of_ones_own(copy):
    (copy / CARD).write_text("anything")
    document = json.loads((copy / MANIFEST).read_text())
    first = {"file": CARD, "bytes": 0, "sha256": ""}
    manifest(copy, files=[first, *document["files"]])
    accept(copy)
    assert failed(copy) == {("file_list", MANIFEST)}


# Tests of the texts


@pytest.mark.parametrize(
    ("place", "found"),
    [(49, {("digits", TEXT_50)}), (25, {("digits", TEXT_50), ("text", TEXT_50)})],
)
def test_a_digit_of_the_text_of_50(copy, place, found):
    # In this row the changed digit brings the number nearer to hi + lo. In other rows the check
    # `text` would also fail.
    change_text(copy, TEXT_50, 8, 8, lambda x: other_digit(x, place))
    assert failed(copy) == found
    for check, _ in found:
        assert "short 1: steer_rate, row 8: found " in message(copy, check)


def test_a_number_of_the_text_of_17_digits(copy):
    change_text(copy, TEXT, 7, 8, lambda x: f"{np.nextafter(float(x), 1.0):.17g}")
    assert failed(copy) == {("text", TEXT)}
    assert "short 1: steer_rate, row 7: found " in message(copy, "text")


def test_a_number_of_more_digits_than_it_needs(copy):
    change_text(copy, TEXT, 7, 8, lambda x: x + "0")
    assert failed(copy) == {("schema", TEXT)}


@pytest.mark.parametrize("name", [TEXT, TEXT_50])
def test_a_time_of_a_text(copy, name):
    change_text(copy, name, 7, 0, lambda x: x + "0")
    assert failed(copy) == {("schema", name)}
    assert "line 8: found time 0.140 s" in message(copy, "schema")


@pytest.mark.parametrize("name", [TEXT, TEXT_50])
def test_a_line_of_a_text_that_is_missing(copy, name):
    path = copy / name
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:-1]))
    accept(copy)
    assert failed(copy) == {("schema", name)}


# Tests of the rows


def test_the_last_bit_of_lo(copy):
    """No text has this alternate column."""
    change(copy, "yaw_rate_lo", 9, lambda x: x * (1 + ULP))
    assert ("rounding", HDF5) in failed(copy)
    assert "short 1: yaw_rate, row 9: found " in message(copy, "rounding")


def test_the_last_bit_of_hi(copy):
    change(copy, "steer_angle", 9, lambda x: x * (1 + ULP))
    assert failed(copy) >= {
        ("rounding", HDF5), ("columns", HDF5), ("contact", HDF5), ("dense_rows", HDF5),
        ("text", TEXT), ("text", TEXT_50),
    }  # fmt: skip
    assert "steer_angle, row 9" in message(copy, "rounding")


@pytest.mark.parametrize("factor", [1 + ULP, 1 - ULP, 0.5, 2.0, 1e30])
def test_a_bound_of_a_row(copy, factor):
    change(copy, "roll_rate_body_x_bound", 3, lambda x: x * factor, in_line=False)
    assert ("row_bounds", HDF5) in failed(copy)
    assert "roll_rate_body_x_bound, row 3" in message(copy, "row_bounds")


@pytest.mark.parametrize("name", ["roll_rate", "kinetic_energy", "time_lo"])
def test_row_zero(copy, name):
    change(copy, name, 0, lambda x: x + 1e-20 if name == "time_lo" else x * (1 + ULP))
    assert ("row_zero", HDF5) in failed(copy)
    assert f"{name.removesuffix('_lo')}, row 0" in message(copy, "row_zero")


def test_a_time(copy):
    change(copy, "time", 5, lambda x: x * (1 + ULP))
    assert failed(copy) == {("row_zero", HDF5)}
    assert "time, row 5" in message(copy, "row_zero")


def test_energies_that_do_not_add_up(copy):
    change(copy, "potential_energy_lo", 4, lambda x: x + 1e-25)
    assert failed(copy) >= {("energy", HDF5), ("columns", HDF5)}
    assert "energies, row 4" in message(copy, "energy")


def test_an_energy_that_changes(copy):
    change(copy, "mechanical_energy_lo", 4, lambda x: x + 1e-25)
    assert "mechanical_energy, row 4: differs from row 0" in message(copy, "energy") or (
        "(and 1 more)" in message(copy, "energy")
    )


def test_a_wheel_off_the_floor(copy):
    change(copy, "pitch_lo", 6, lambda x: x + 1e-26)
    assert ("contact", HDF5) in failed(copy)
    assert "front wheel, row 6: " in message(copy, "contact")


def test_a_column_that_does_not_follow_from_the_state(copy):
    change(copy, "forward_speed_com_norm_lo", 6, lambda x: x + 1e-26)
    assert failed(copy) == {
        ("columns", HDF5), ("rounding", HDF5), ("row_bounds", HDF5), ("dense_rows", HDF5),
    }  # fmt: skip
    assert "forward_speed_com_norm, row 6: differs by" in message(copy, "columns")


# Tests of the dense output


def breaks(folder):
    with h5py.File(folder / HDF5) as f:
        return f["maneuver_1/dense/breaks"][:]


def test_a_dense_coefficient(copy):
    t = breaks(copy)[1]
    change(copy, "dense/steer_rate_lo", (1, 0), lambda x: x + 1e-28)
    assert failed(copy) == {("dense_rows", HDF5), ("dense_joins", HDF5)}
    first = int(np.ceil(t / 0.02))
    assert f"dense steer_rate, row {first}: differs by" in message(copy, "dense_rows")
    assert f"dense steer_rate, break 1 (t = {t:.6g} s): jumps by" in message(copy, "dense_joins")


def test_dense_coefficients_that_leave_the_ends_alone(copy):
    """T_2 - T_0 is zero at both ends of a segment."""
    change(copy, "dense/yaw_lo", (0, 0), lambda x: x - 1e-27)
    change(copy, "dense/yaw_lo", (0, 2), lambda x: x + 1e-27)
    assert failed(copy) == {("dense_rows", HDF5)}


def test_dense_coefficients_that_leave_the_rows_alone(copy):
    """A polynomial that is zero at the rows of the first segment, but not at its right end."""
    width = breaks(copy)[1]
    rows = 2 * np.arange(0.0, width, 0.02) / width - 1
    assert 2 <= len(rows) <= 10
    zero = np.polynomial.chebyshev.chebfromroots(rows)
    zero *= 1e-22 / np.polynomial.chebyshev.chebval(1.0, zero)
    change(copy, "dense/yaw_lo", (0, slice(0, len(zero))), lambda x: x + zero)
    assert failed(copy) == {("dense_joins", HDF5)}


def test_a_dense_bound(copy):
    with h5py.File(copy / HDF5) as f:
        largest = int(np.argmax(f["maneuver_1/dense/pitch_bound"][:]))
    # The first change is in the segment with the largest bound, which the certificate states. The
    # second one is in the segment of row 0. This row is exact with a bound of zero, so only the
    # polynomial's own bound is allowed there.
    assert largest != 0
    for piece in (largest, 0):
        change(copy, "dense/pitch_bound", piece, lambda x: x * 1e-3, in_line=False)
    assert failed(copy) >= {("dense_rows", HDF5), ("certificate", CERTIFICATE)}
    assert "dense pitch, row" in message(copy, "dense_rows")


# Tests of the certificate


def entry(document):
    return document["maneuvers"][0]


@pytest.mark.parametrize(
    ("new", "check", "fragment"),
    [
        (lambda d: d.update(statement="It is so."), "schema", "statement"),
        (lambda d: d["trusted"].pop(), "schema", "trusted"),
        (lambda d: d["inputs"]["bicycle"].update(name="mine"), "schema", "inputs"),
        (lambda d: d["software"].clear(), "schema", "flint"),
        (lambda d: d["maneuvers"].clear(), "schema", "0 maneuvers"),
        (lambda d: entry(d).pop("entries"), "schema", "expected the entries"),
        (lambda d: entry(d)["state_bounds"]["yaw"].update(end="nan"), "schema", "yaw"),
        (lambda d: entry(d).update(bound="1e-99"), "certificate", "bound"),
        (lambda d: entry(d).update(bound_end="1e-99"), "certificate", "bound_end"),
        (lambda d: entry(d).update(steps=7), "certificate", "steps"),
        (lambda d: entry(d).update(entries=7), "certificate", "entries"),
        # A dataset without undecided entries must not mention such entries.
        (lambda d: entry(d).update(ambiguous=1), "schema", "statement"),
        (lambda d: entry(d).update(maneuver="x"), "certificate", "maneuver"),
        (lambda d: entry(d)["dense_relative_bounds"].update(yaw="1.00e-32"), "certificate", "yaw"),
        (lambda d: entry(d)["state_bounds"]["roll"].update(end="1e-20"), "certificate", "roll"),
    ],
)
def test_what_the_certificate_says(copy, new, check, fragment):
    change_json(copy, new)
    assert (check, CERTIFICATE) in failed(copy)
    assert fragment in message(copy, check)


def test_a_certificate_that_decides_nothing(copy):
    def widen(document):
        for bounds in entry(document)["state_bounds"].values():
            bounds.update(interval="1e-20")
        entry(document).update(bound="1e-20")

    change_json(copy, widen)
    assert ("rounding", HDF5) in failed(copy)
    assert "the certificate's bounds are too large" in message(copy, "rounding")


def test_digits_are_the_candidate_s_where_the_largest_bound_does_not_decide_them(copy):
    """A bound of 1e-52 alone does not decide the last of 50 digits."""

    def widen(document):
        for bounds in entry(document)["state_bounds"].values():
            bounds.update(interval="1e-52", end="1e-52")
        entry(document).update(bound="1e-52", bound_end="1e-52")

    change_json(copy, widen)
    assert not failed(copy) & {("rounding", HDF5), ("digits", TEXT_50)}
    change_text(copy, TEXT_50, 1, 1, lambda text: other_digit(text, 49))
    assert ("digits", TEXT_50) in failed(copy)


# Tests of the candidate


def change_candidate(folder, piece, state, power, amount):
    """Add to a coefficient, in units of the state variable."""
    with h5py.File(folder / CANDIDATE, "r+") as f:
        group = f["maneuver_1"]
        item = group["coefficients"]
        n = int.from_bytes(item[piece, state, power].tobytes(), "little", signed=True)
        n += int(Fraction(amount) * 2 ** int(group.attrs["grid"]))
        width = item.shape[-1]
        item[piece, state, power] = np.frombuffer(n.to_bytes(width, "little", signed=True), "u1")
        last = item.shape[0] - 1
    accept(folder)
    return last


def test_a_coefficient_of_the_candidate(copy):
    change_candidate(copy, 1, 0, 20, Fraction(1, 10**70))
    assert failed(copy) == {("candidate_joins", CANDIDATE)}
    assert "short 1: roll jumps by 1e-70 at break 2" in message(copy, "candidate_joins")


def test_the_start_of_the_candidate(copy):
    """Change constant and linear coefficients together, so that the segments still join."""
    change_candidate(copy, 0, 0, 0, Fraction(1, 10**68))
    change_candidate(copy, 0, 0, 1, -Fraction(1, 10**68))
    assert ("candidate_joins", CANDIDATE) in failed(copy)
    assert "value of roll differs by 1e-68" in message(copy, "candidate_joins")


def test_a_motion_that_does_not_obey_the_equations(copy):
    """The change is in the last segment, which need not join another, and below the 50 digits."""
    last = change_candidate(copy, -1, 2, 3, Fraction(1, 10**58))
    # The energy of the changed motion also drifts, so the check `integration` fails too.
    assert failed(copy) == {("equations_of_motion", CANDIDATE), ("integration", CANDIDATE)}
    assert last > 1
    assert "off the equations" in message(copy, "equations_of_motion")


@pytest.mark.parametrize(
    ("name", "value", "fragment"),
    [
        ("grid", 7, "grid"), ("precision_bits", 113, "bits"), ("form", "regular", "states"),
        ("form", "mine", "form"), ("speed", "4", "speed"), ("taylor_order", 3, "coefficients"),
        ("states", '["x"]', "states"), ("notes", "mine", "unknown"), ("name", "mine", "name"),
    ],
)  # fmt: skip
def test_an_attribute_of_the_candidate(copy, name, value, fragment):
    with h5py.File(copy / CANDIDATE, "r+") as f:
        f["maneuver_1"].attrs[name] = value
    accept(copy)
    assert failed(copy) == {("schema", CANDIDATE)}
    assert fragment in message(copy, "schema")


# Tests of the structure of the HDF5 file


def replace(group, name, data):
    del group[name]
    group.create_dataset(name, data=data)


@pytest.mark.parametrize(
    ("do", "fragment"),
    [
        (lambda m: m["yaw"].attrs.modify("units", "deg"), "yaw: attribute units: found 'deg'"),
        (lambda m: m["yaw"].attrs.modify("positive", "to the left"), "positive"),
        (lambda m: m["roll_angle_zyx"].attrs.modify("definition", "x"), "definition"),
        (lambda m: m["dense/yaw_lo"].attrs.modify("long_name", "x"), "long_name"),
        (lambda m: m["yaw_bound"].attrs.modify("definition", "x"), "definition: found 'x'"),
        (lambda m: m["dense"].attrs.__delitem__("comment"), "comment"),
        (lambda m: m["dense"].attrs.modify("comment", "x"), "comment: found 'x'"),
        (lambda m: m.attrs.modify("speed", "5"), "speed"),
        (lambda m: m.attrs.__setitem__("note", "mine"), "note"),
        (lambda m: m.__delitem__("pitch_bound"), "has no pitch_bound"),
        (lambda m: m.__setitem__("mine", 1.0), "'mine'"),
        (lambda m: replace(m, "yaw", m["yaw"][:].astype("f4")), "float32"),
        (lambda m: replace(m, "yaw", m["yaw"][:-1]), "(10,)"),
        (lambda m: replace(m, "yaw", m["yaw"][:]), "yaw"),
        (lambda m: m["yaw"].dims[0].detach_scale(m["time"]), "scale"),
        (lambda m: m["yaw_lo"].__setitem__(3, np.nan), "not finite"),
        (lambda m: m["dense/yaw"].__setitem__((0, 3), np.inf), "not finite"),
        (lambda m: m["yaw_bound"].__setitem__(3, -1.0), "negative"),
        (lambda m: m["dense/yaw_bound"].__setitem__(0, -1.0), "negative"),
        (lambda m: m["dense/breaks"].__setitem__(0, 0.1), "increase"),
        (lambda m: m["dense/order"].__setitem__(0, 5), "order"),
        (lambda m: m.__delitem__("dense"), "dense"),
    ],
)
def test_how_the_hdf5_file_is_built(copy, do, fragment):
    with h5py.File(copy / HDF5, "r+") as f:
        do(f["maneuver_1"])
    accept(copy)
    assert ("schema", HDF5) in failed(copy)
    assert fragment in message(copy, "schema")
    # If the structure of the file is wrong, its numbers are not checked. This does not count as
    # another failure.
    assert {c.passed for c in outcomes(copy) if c.check == "rounding"} == {None}


@pytest.mark.parametrize(
    "name", ["dataset_version", "content_sha256", "parameters", "Conventions", "title", "comment"]
)
def test_an_attribute_of_the_whole_hdf5_file(copy, name):
    with h5py.File(copy / HDF5, "r+") as f:
        f.attrs[name] = "x"
    accept(copy)
    assert failed(copy) == {("schema", HDF5)}
    assert f"attribute {name}: found 'x'" in message(copy, "schema")


def test_the_sensitivities_are_those_of_the_inputs(copy):
    with h5py.File(copy / "sensitivities.h5", "r+") as f:
        f["maneuver_1"].attrs["speed"] = "5"
    accept(copy)
    assert failed(copy) == {("schema", "sensitivities.h5")}


@pytest.mark.parametrize(
    ("do", "fragment"),
    [
        (lambda f: f.attrs.modify("unknown_units", "[]"), "unknown_units"),
        (lambda f: f["maneuver_1/yaw"].attrs.modify("units", "deg"), "yaw: attribute units"),
        (lambda f: f["maneuver_1"].attrs.__setitem__("note", "mine"), "note"),
        (lambda f: f["maneuver_1"].__delitem__("yaw"), "has no yaw"),
        (lambda f: replace(f["maneuver_1"], "yaw", f["maneuver_1/yaw"][:, :1]), "expected"),
        (lambda f: f["maneuver_1/breaks"].__setitem__(0, 0.1), "increase"),
        (lambda f: f["maneuver_1/yaw"].__setitem__((0, 0, 0), np.inf), "not finite"),
    ],
)
def test_how_the_sensitivities_are_built(copy, do, fragment):
    with h5py.File(copy / "sensitivities.h5", "r+") as f:
        do(f)
    accept(copy)
    assert failed(copy) == {("schema", "sensitivities.h5")}
    assert fragment in message(copy, "schema")


def test_a_changed_sensitivity(copy):
    # The sensitivities of the yaw have no values at the rows, so only the hash of the numbers shows
    # the change.
    with h5py.File(copy / "sensitivities.h5", "r+") as f:
        f["maneuver_1/yaw"][0, 0, 0] += 1e-3
    accept(copy)
    assert "is not the hash of the numbers" in message(copy, "schema")
    # The sensitivities of the roll angle also have values at the rows, which differ from the
    # changed polynomials.
    with h5py.File(copy / "sensitivities.h5", "r+") as f:
        f["maneuver_1/roll_angle"][0, 0, 0] += 1e-3
    accept(copy)
    assert "roll_angle: differs from the pieces" in message(copy, "schema")


def test_sensitivities_of_the_energies_must_add_up(copy):
    with h5py.File(copy / "sensitivities.h5", "r+") as f:
        for name in ("maneuver_1/kinetic_energy_bound", "maneuver_1/rows/kinetic_energy_bound"):
            # The bounds become so wide that the values at the rows do not violate them.
            f[name][...] = 1.0
        f["maneuver_1/kinetic_energy"][0, 0, 0] += 1e-3
    accept(copy)
    assert "do not add up" in message(copy, "schema")


def test_rows_of_sensitivities_that_are_not_those_of_the_pieces(copy):
    with h5py.File(copy / "sensitivities.h5", "r+") as f:
        item = f["maneuver_1/rows/roll_rate"]
        item[0, 3] = item[0, 3] + 1e-3
        f.attrs["content_sha256"] = content_sha256(f)
    accept(copy)
    assert failed(copy) == {("schema", "sensitivities.h5")}
    assert "rows/roll_rate: differs from the pieces" in message(copy, "schema")


# Tests of the manifest


def test_a_content_hash_that_is_not_that_of_the_numbers(copy):
    with h5py.File(copy / HDF5, "r+") as f:
        f.attrs["content_sha256"] = "0" * 64
    manifest(copy, content_sha256="0" * 64)
    accept(copy)
    assert failed(copy) == {("content_sha256", HDF5)}


def test_inputs_of_the_manifest(copy):
    document = json.loads((copy / MANIFEST).read_text())
    document["inputs"]["maneuvers"][0]["speed"] = "5"
    manifest(copy, inputs=document["inputs"])
    assert failed(copy) >= {
        ("schema", HDF5), ("schema", CANDIDATE), ("schema", CERTIFICATE),
        ("schema", "sensitivities.h5"),
    }  # fmt: skip


@pytest.mark.parametrize(("key", "value"), [("speed", "1/0"), ("spacing", "0"), ("speed", 3)])
def test_inputs_that_cannot_be_used(copy, key, value):
    document = json.loads((copy / MANIFEST).read_text())
    document["inputs"]["maneuvers"][0][key] = value
    manifest(copy, inputs=document["inputs"])
    assert failed(copy) == {("inputs", MANIFEST)}


def test_a_file_that_the_manifest_leaves_out(copy):
    document = json.loads((copy / MANIFEST).read_text())
    files = [f for f in document["files"] if f["file"] != TEXT]
    manifest(copy, files=files)
    assert failed(copy) == {("file_list", MANIFEST)}
    assert f"has no entry for {TEXT}" in message(copy, "file_list")


def test_a_file_that_is_no_part_of_a_set(copy):
    (copy / "z.txt").write_text("mine")
    document = json.loads((copy / MANIFEST).read_text())
    manifest(copy, files=[*document["files"], {"file": "z.txt", "bytes": 0, "sha256": ""}])
    accept(copy)
    assert failed(copy) == {("file_list", MANIFEST)}


def test_a_manifest_written_another_way(copy):
    path = copy / MANIFEST
    path.write_text(path.read_text().replace("  ", "   ", 1))
    assert failed(copy) == {("manifest", MANIFEST)}
    manifest(copy, notes="mine")
    assert failed(copy) == {("manifest", MANIFEST)}


@pytest.mark.parametrize("version", ["1.0.1", "Custom", "0.9.0"])
def test_a_version_that_nobody_knows(copy, version):
    manifest(copy, dataset_version=version)
    assert ("manifest_hash", MANIFEST) in failed(copy)


def test_numbers_that_overflow_are_no_internal_error(copy, capsys):
    for name in ("kinetic_energy", "potential_energy"):
        change(copy, name, 3, lambda x: 1.7e308)
    change(copy, "steer_angle", 4, lambda x: -1.7e308)
    change(copy, "dense/yaw", (0, 3), lambda x: 1.7e308)
    assert main(["verify", str(copy)]) == 3
    assert "internal error" not in capsys.readouterr().err
