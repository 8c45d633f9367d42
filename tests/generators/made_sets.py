"""Small reference datasets from `generate`, in older formats too, and manifests for damage."""

import json

import h5py

from heyoka_bike.cli import main
from heyoka_bike.reference.layout import content_sha256
from heyoka_bike.reference.manifest import MANIFEST, sha256
from heyoka_bike.reference.proof.certificate import STATEMENT_1_5_0


def make(where, *maneuvers):
    """Make a dataset of the benchmark bicycle; each maneuver is (duration, spacing)."""
    text = 'name = "short"\n' + "".join(
        f'[[maneuver]]\nname = "short {i}"\nspeed = "4.6"\nroll_rate = "0.5"\n'
        f'duration = "{duration}"\nspacing = "{spacing}"\n'
        for i, (duration, spacing) in enumerate(maneuvers, start=1)
    )
    (where / "m.toml").write_text(text)
    out = where / "set"
    assert main(["generate", "--maneuvers", str(where / "m.toml"), "--out", str(out)]) == 0
    return out


def manifest(folder, **changes):
    """Write entries of the manifest, in its canonical form."""
    path = folder / MANIFEST
    document = json.loads(path.read_text()) | changes
    path.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")


def accept(folder):
    """Update sizes and hashes in the manifest to match the files."""
    document = json.loads((folder / MANIFEST).read_text())
    document["files"] = [x for x in document["files"] if (folder / x["file"]).exists()]
    for entry in document["files"]:
        data = (folder / entry["file"]).read_bytes()
        entry |= {"bytes": len(data), "sha256": sha256(data)}
    manifest(folder, files=document["files"])


def accept_numbers(folder, f):
    """Update content_sha256 to match the numbers of an open HDF5 file."""
    content = content_sha256(f)
    f.attrs["content_sha256"] = content
    manifest(folder, content_sha256=content)


_ADDED = {
    "1.3.0": (
        "roll_rate_steer_axes_x", "forward_speed_contact_global_x", "forward_speed_com_heading",
        "forward_speed_com_global_x", "forward_speed_front_hub_heading",
        "forward_speed_front_hub_norm", "forward_speed_front_hub_global_x",
        "forward_speed_front_contact", "forward_speed_front_contact_heading",
        "forward_speed_front_contact_global_x", "forward_speed_front_wheel_heading",
        "forward_speed_front_wheel_spin", "pitch_zyx", "pitch_steer_axes", "yaw_rate_body_z",
        "yaw_rate_steer_axes_z",
    ),
}  # fmt: skip
_ROWS_ONLY = ("omega", "moment", "axle_force", "joint_force", "hub", "frame_r", "frame_com")


def older(folder, version):
    """Remove from a custom dataset everything that this version did not have.

    See CHANGELOG-dataset.md. Texts of the certificate are replaced with those of the version.
    """
    files = ("uncontrolled-bicycle.h5", "motion.h5", "sensitivities.h5", "candidate.h5")
    for name in files:
        with h5py.File(folder / name, "r+") as f:
            if version < "1.5.0":
                _without_description(f)
            if name == "sensitivities.h5" and version < "1.4.0":
                f.attrs["comment"] = "other words"
                _without(f["maneuver_1"], lambda x: x == "rows" or x.endswith("_bound"))
            if version < "1.3.0" and name in ("uncontrolled-bicycle.h5", "sensitivities.h5"):
                for group in (f["maneuver_1"], f["maneuver_1"].get("dense")):
                    if group is not None:
                        _without(group, lambda x: _stem(x) in _ADDED["1.3.0"])
            if version < "1.3.0" and name == "motion.h5":
                _without(f["maneuver_1/dense"], lambda x: any(part in x for part in _ROWS_ONLY))
            if name == "uncontrolled-bicycle.h5":
                accept_numbers(folder, f)
            elif name != "candidate.h5":
                f.attrs["content_sha256"] = content_sha256(f)
    for name in ("states.csv", "states.h5"):
        (folder / name).unlink()
    _older_certificate(folder / "certificate.json", version)
    accept(folder)


def _older_certificate(path, version):
    document = json.loads(path.read_text())
    (entry,) = document["maneuvers"]
    document["statement"] = STATEMENT_1_5_0
    entry.pop("integration")
    for name in ("states.csv", "states.h5"):
        document["proved"].pop(name)
    if version < "1.4.0":
        document["statement"] = "Less is proved."
        document["proved"].pop("sensitivities.h5")
        document["computed"] = {"sensitivities.h5": "in binary128"}
        entry.pop("sensitivities")
    if version < "1.3.0":
        for part in ("proved", "computed"):
            document.pop(part)
        entry.pop("motion")
        for name in _ADDED["1.3.0"]:
            entry["dense_relative_bounds"].pop(name)
        rows = entry["entries"] // 38
        entry["entries"] = rows * 22
    path.write_text(json.dumps(document, indent=2, ensure_ascii=False) + "\n")


def _without_description(f):
    """Remove attributes of ACDD-1.3, and those of axes."""
    for name in ("summary", "keywords", "source", "references", "history"):
        del f.attrs[name]
    f.attrs["Conventions"] = "CF-1.8"
    for group in f.values():
        if "dense" in group:
            group["time"].attrs["axis"] = "T"
            for axis in ("piece", "order"):
                for name in ("units", "long_name", "definition"):
                    del group["dense"][axis].attrs[name]


def _without(group, is_gone):
    for name in [x for x in group if is_gone(x)]:
        del group[name]


def _stem(name):
    return name.removesuffix("_lo").removesuffix("_bound")
