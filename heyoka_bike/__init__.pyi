# isort: skip_file
# The public names, and where each lives: `__init__.py` and type checkers read this one list.

from heyoka_bike.version import __version__ as __version__

# Read the reference.
from heyoka_bike.reference.load import Reference as Reference
from heyoka_bike.reference.load import load_reference as load_reference
from heyoka_bike.reference.load import load_motion as load_motion
from heyoka_bike.reference.load import load_sensitivities as load_sensitivities

# Judge a file.
from heyoka_bike.scoring.reading.results import Results as Results
from heyoka_bike.scoring.reading.source import read_results as read_results
from heyoka_bike.scoring.report import Report as Report
from heyoka_bike.scoring.runs import Series as Series
from heyoka_bike.scoring.diagnosis.diagnose import diagnose as diagnose
from heyoka_bike.scoring.instants.check import check as check
from heyoka_bike.scoring.score import score as score
from heyoka_bike.scoring.series import score_series as score_series
from heyoka_bike.scoring.series import compare as compare

# Show.
from heyoka_bike.workbench.figures import plot as plot
from heyoka_bike.workbench.replay.page import animate as animate

# Compute.
from heyoka_bike.bicycle.parameters import Bicycle as Bicycle
from heyoka_bike.bicycle.parameters import Maneuver as Maneuver
from heyoka_bike.bicycle.parameters import read_bicycle as read_bicycle
from heyoka_bike.bicycle.parameters import read_maneuvers as read_maneuvers
from heyoka_bike.bicycle.stability.linear import linearise as linearise
from heyoka_bike.motion.events import follow as follow
from heyoka_bike.workbench.fast.ensemble import Ensemble as Ensemble
from heyoka_bike.workbench.fast.simulate import simulate as simulate
from heyoka_bike.motion.integrate import integrate as integrate
from heyoka_bike.motion.trajectory import Trajectory as Trajectory
from heyoka_bike.numbers.exact import Exact as Exact

# Make and check sets.
from heyoka_bike.reference.making import generate as generate
from heyoka_bike.reference.proof.certify import certify as certify
from heyoka_bike.reference.verification.verify import verify as verify
from heyoka_bike.system.parallel import using as using

# Catch.
from heyoka_bike.errors import BicycleError as BicycleError
from heyoka_bike.errors import DatasetError as DatasetError
from heyoka_bike.errors import InputError as InputError
from heyoka_bike.errors import MissingPackageError as MissingPackageError
from heyoka_bike.errors import NotCertifiedError as NotCertifiedError
from heyoka_bike.errors import NothingScoredError as NothingScoredError
from heyoka_bike.errors import SingularMotionError as SingularMotionError
from heyoka_bike.errors import VersionsDifferError as VersionsDifferError
from heyoka_bike.errors import WorkerLostError as WorkerLostError
