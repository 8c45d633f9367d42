"""The state in which a program begins a maneuver."""

from heyoka_bike.bicycle.equations.initial import pitch_on_the_floor
from heyoka_bike.bicycle.equations.reduced import Equations
from heyoka_bike.numbers.arithmetic import Arrays
from heyoka_bike.scoring.diagnosis.programs.program import Program
from heyoka_bike.scoring.diagnosis.programs.start import initial_state


def beginning(program: Program, number: int) -> tuple[float, ...]:
    """That of a maneuver as `initial_state` has it, with both wheels on the floor."""
    p = {symbol: float(x) for symbol, x in program.bicycle.values.items()}
    roll, pitch, steer, *rates = initial_state(p, program.starts[number])
    if steer != 0.0:
        k = Equations.of(program.bicycle, Arrays()).k
        pitch = float(pitch_on_the_floor(k, roll, 0.0, steer))
    return roll, pitch, steer, *rates
