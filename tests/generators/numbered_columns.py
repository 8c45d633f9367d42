"""Small files whose numbers encode column and row."""

COUNT = 6


def written(tmp_path, *heading, width=3):
    """Write a file in which column j (from 0) of row i is 100 i + j."""
    path = tmp_path / "r.csv"
    rows = [",".join(str(100 * i + j) for j in range(width)) for i in range(COUNT)]
    path.write_text("\n".join([*heading, *rows]) + "\n")
    return path


def found(results):
    """Return the index (from 0) of the column that each key was read from."""
    columns = {"time": int(results.maneuvers[0].time[0])}
    for rows in results.maneuvers:
        columns |= {(rows.maneuver, key): int(x[0]) for key, x in rows.values.items()}
    return columns
