"""Published submissions, copied to a folder that a test may change."""

import shutil

from heyoka_bike.system.resources import data_folder
from heyoka_bike.workbench.leaderboard.ranking import read_submission

RESULTS = data_folder() / "results"
SCIPY, EXUDYN = "scipy-dop853.toml", "exudyn-trapezoidal.toml"


def copied(folder, names=(SCIPY, EXUDYN)):
    """Copy these submissions and their files to a new folder; SciPy's is the better one."""
    folder.mkdir()
    for name in names:
        shutil.copy(RESULTS / name, folder)
        for file in read_submission(RESULTS / name).files:
            shutil.copy(file.path, folder)
    return folder
