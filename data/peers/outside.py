"""An integrator from outside, for programs that give accelerations."""

from scipy.integrate import solve_ivp


def one_step(rates, y, h):
    """State after a step of SciPy's DOP853, whose rates are a function of it."""
    # So loose that the first step is accepted as it is.
    loose = {"first_step": h, "rtol": 1, "atol": 1}
    return solve_ivp(lambda _, x: rates(x), (0, h), y, method="DOP853", **loose).y[:, -1]
