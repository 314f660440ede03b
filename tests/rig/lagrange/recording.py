"""The second rig's loop, and the logger that spoils what it recorded."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numba
import numpy as np

from tests.rig.loop import contact_coefficients
from tests.rig.recording import COLUMNS, Recording, excited

from .laws import FAULTS, LAWS, LISTED
from .plant import LAG, N_STATES, Body, S, V, X, midpoint, reading

T = 1e-3  # s
N_INNER = 10  # steps of the integrator in a tick
DEAD_TICKS = 2
NONE = "none"
NO_FAULT = -1
LATE_FORCE, WRONG_SIGN, CLIPPED, ROUNDED, WRONG_LAG, NO_CORRECTION, STALE_POSITION = range(len(FAULTS))
FAR = 1.0  # m
BELIEVED = Body()


@dataclass(frozen=True)
class Nuisance:
    """
    What a logger and a room do to a recording; zero is off.

    `sigma`, `pink`, `hum` and `spikes` are forces [N]: rms of white and of 1/f noise, amplitude at 50 Hz,
    size of one row in 700. `bits` of the force converter over +-500 N, `dropped` share of rows whose value is
    the one before, `skew` of the clock, `digits` of a short print, `off` of the plant's numbers from nominal.
    """

    sigma: float = 0.5
    pink: float = 0.0
    hum: float = 0.0
    spikes: float = 0.0
    bits: int = 0
    dropped: float = 0.0
    skew: float = 0.0
    digits: int = 0
    off: float = 0.1


NUISANCES = {
    "white": Nuisance(),
    "pink": Nuisance(sigma=0.3, pink=0.5),
    "hum": Nuisance(hum=0.6),
    "spikes": Nuisance(spikes=4.0),
    "bits": Nuisance(sigma=0.2, bits=12),
    "dropped": Nuisance(dropped=0.002),
    "skew": Nuisance(skew=2e-4),
    "digits": Nuisance(digits=4),
    "off": Nuisance(off=0.2),
}


def record(
    law: str = NONE, factor: float = 1.0, *, nuisance: str = "white", seed: int = 1, duration: float = 10.0
) -> Recording:
    """
    Let the rig run and record it.

    Args:
        law: Name in `LAWS`, `LISTED` or `FAULTS`, several joined by `+`, or NONE.
        factor: Size over the laws' typical one.
        nuisance: Name in `NUISANCES`.
        seed: Of noise and of the plant's numbers.
        duration: [s]

    Returns:
        Columns as of the first rig.
    """
    spoilt = NUISANCES[nuisance]
    rng = np.random.default_rng(seed)
    true = _off(BELIEVED, spoilt.off, rng)  # the first that is drawn: `true_body` draws it alone
    t = np.arange(round(duration / T)) * T
    added = excited("rich", t)
    noise = rng.standard_normal((len(t), 3))
    force_noise = spoilt.sigma * noise[:, 0] + spoilt.pink * pink(rng, len(t))
    force_noise += spoilt.hum * np.sin(2.0 * np.pi * 50.0 * t + rng.uniform(0.0, 6.0))
    hit = rng.random(len(t)) < 1.0 / 700.0
    force_noise[hit] += spoilt.spikes * rng.choice([-1.0, 1.0], int(hit.sum()))
    step = 1000.0 / 2**spoilt.bits if spoilt.bits else 0.0
    laws = [(LAWS | LISTED)[name] for name in law.split("+") if name not in (NONE, *FAULTS)]
    numbers = np.array([own.number for own in laws], dtype=np.int64)
    sizes = np.array([own.size * factor for own in laws], dtype=np.float64)
    fault = list(FAULTS).index(law) if law in FAULTS else NO_FAULT
    errors = np.column_stack([force_noise, 2e-6 * noise[:, 1], 5e-5 * noise[:, 2]])
    rows = run(true, numbers, sizes, fault, added, errors, T * (1.0 + spoilt.skew), step)
    n = len(rows)
    columns = dict(zip(COLUMNS, [t[:n], *rows.T, np.zeros(n), added[:n]], strict=True))
    lost = rng.random(n) < spoilt.dropped
    for k in np.flatnonzero(lost[1:]) + 1:
        columns["f_mea"][k] = columns["f_mea"][k - 1]
    if spoilt.digits:
        columns = {name: _printed(values, spoilt.digits) for name, values in columns.items()}
        columns["t"] = t[:n]
    return Recording({name: np.ascontiguousarray(values) for name, values in columns.items()})


def true_body(nuisance: str, seed: int) -> Body:
    """Numbers of the plant in a recording with this nuisance and seed."""
    return _off(BELIEVED, NUISANCES[nuisance].off, np.random.default_rng(seed))


def _off(body: Body, share: float, rng: np.random.Generator) -> Body:
    """The plant's own numbers, each up to a share off; filter and spacecraft are known."""
    names = set(body._fields) - {"T_f", "m_s"}
    factors = {name: rng.uniform(1.0 - share, 1.0 + share) for name in sorted(names)}
    return body._replace(**{name: getattr(body, name) * f for name, f in factors.items()})


def _printed(values: np.ndarray, digits: int) -> np.ndarray:
    """Numbers as a print with a fixed resolution leaves them: a share of the largest."""
    largest = float(np.abs(values).max())
    if largest == 0.0:
        return values
    step = 10.0 ** (np.ceil(np.log10(largest)) - digits)
    return np.asarray(np.round(values / step) * step)


def pink(rng: np.random.Generator, n: int) -> np.ndarray:
    """Noise of power 1/f and unit variance, shape (n,)."""
    spectrum = np.fft.rfft(rng.standard_normal(n))
    spectrum[1:] /= np.sqrt(np.arange(1, len(spectrum)))
    spectrum[0] = 0.0
    values = np.fft.irfft(spectrum, n)
    return np.asarray(values / values.std())


@numba.njit(cache=True)
def run(b, laws, sizes, fault, excitation, errors, tick, step):
    """Rows of s_des, s_cmd, s_act, v_act, f_des, f_mea, shape (n, 6), as the compensator reads them."""
    n = len(excitation)
    rows = np.zeros((n, 6))
    commands = np.zeros(n)
    y = np.zeros(N_STATES)
    s0 = -5e-3
    y[S] = s0
    y[X] = b.k_p / (b.k_m + b.k_p) * s0
    y[LAG] = -b.k_m * y[X]
    s_des, v_des, last_f = s0, 0.0, 0.0
    df1 = df2 = ds1 = ds2 = 0.0
    held = 0.0
    late_f = 0.0
    used = s0
    a1, a2, c0, c1, c2 = contact_coefficients(BELIEVED, T)
    for k in range(n):
        t = k * tick
        f_mea = reading(t, y[LAG], laws, sizes) + errors[k, 0]
        for i, law in enumerate(laws):
            size = sizes[i]
            if law == 30 and k > 0 and (k * 7919) % 1000 < 1000.0 * size / 20.0:
                held = 20.0
        if held > 0.0:
            f_mea = rows[k - 1, 5]
            held -= 1.0
        if step > 0.0:
            f_mea = step * np.floor(f_mea / step + 0.5)
        s_act = y[S] + errors[k, 1]
        if fault != STALE_POSITION or k % 2 == 0:
            used = s_act
        ds = s_des - used
        df = a1 * df1 + a2 * df2 - (c0 * ds + c1 * ds1 + c2 * ds2)
        df2, df1, ds2, ds1 = df1, df, ds1, ds
        if k == 0:
            last_f = f_mea
            late_f = f_mea
        f_in = late_f if fault == LATE_FORCE else f_mea
        late_f = f_mea
        lag = 1.4 * BELIEVED.T_f if fault == WRONG_LAG else BELIEVED.T_f
        f_led = f_in + lag * (f_in - last_f) / T
        last_f = f_in
        if fault == WRONG_SIGN:
            f_des = f_led - df
        elif fault == NO_CORRECTION:
            f_des = f_led
        else:
            f_des = f_led + df
        if fault == CLIPPED:
            f_des = min(max(f_des, -60.0), 60.0)
        elif fault == ROUNDED:
            f_des = math.floor(f_des + 0.5)
        s_cmd = s_des + excitation[k]
        rows[k] = (s_des, s_cmd, s_act, y[V] + errors[k, 2], f_des, f_mea)
        v_des += T * f_des / BELIEVED.m_s
        s_des += T * v_des
        commands[k] = s_cmd
        command = commands[k - DEAD_TICKS] if k >= DEAD_TICKS else s0
        for i in range(N_INNER):
            midpoint(t + i * tick / N_INNER, y, tick / N_INNER, command, b, laws, sizes)
        if abs(s_des) > FAR:
            return rows[: k + 1]
    return rows
