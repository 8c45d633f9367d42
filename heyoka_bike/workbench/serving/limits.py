"""Limits of one request to a server."""

from dataclasses import dataclass

from heyoka_bike.system.jobs import ProcessLimits

_MB = 1_000_000


@dataclass(frozen=True, slots=True)
class Limits:
    """Limits of one request, and of what is stored of it.

    Attributes
    ----------
    upload : int
        Of all that one request holds [bytes].
    files
        Result files in one request.
    score_seconds, diagnose_seconds : float
        For a piece of work, processor time and time on the clock [s].
    upload_seconds : float
        For a request to arrive [s].
    memory : int
        Of the process of a piece of work [bytes].
    workers
        Pieces of work at once.
    waiting
        That wait for one of them.
    kept_seconds : float
        How long a result is kept [s].
    kept
        Results at once; the oldest make room.
    kept_bytes : int
        Of all results and their files [bytes].
    arriving_bytes : int
        Of all requests that are not kept yet [bytes].
    has_diagnosis
        Whether ``diagnose`` is offered.
    """

    upload: int = 100 * _MB
    files: int = 20
    score_seconds: float = 60.0
    diagnose_seconds: float = 180.0
    upload_seconds: float = 600.0
    memory: int = 2000 * _MB
    workers: int = 2
    waiting: int = 100
    kept_seconds: float = 86400.0
    kept: int = 1000
    kept_bytes: int = 4000 * _MB
    arriving_bytes: int = 2000 * _MB
    has_diagnosis: bool = True

    def of_process(self, is_long: bool) -> ProcessLimits:
        """Of the process of a piece of work; a diagnosis is long."""
        seconds = self.diagnose_seconds if is_long else self.score_seconds
        return ProcessLimits(seconds, self.memory)
