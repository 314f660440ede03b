"""
Robust compensation: models of contact and plant that correct themselves, and say what they trust.

    G(s)   = (k_m + c_m s)(k_p + c_p s)/(m_e s^2 + (c_m + c_p) s + k_m + k_p)      bilinear: y = G(q) s
    y_d, y_0 = G(q) (s_des - x), G(q) (s_act - x),   y_a = y_0 with the lag T_f_hat of the sensor
    t_s    = c_m/k_m + c_p/k_p - (c_m + c_p)/(k_m + k_p)                  loss of the contact as a time
    w_1    : m_s w^2 (k_m + k_p - m_e w^2) = k_m k_p, the lower root      loop frequency of the prior
    with the contact `direct`:  y = k_m s + c_m (s - s(k-1))/T,   t_s = c_m/k_m,   w_1 = sqrt(k_m/m_s)

What is wrong in the prior is a share kappa of the stiffness and a time epsilon, of the lag of the sensor or
of the damping, c/k; one oscillation does not tell these two apart, `latency_tolerance` does (w_T below).
In doubt, -1, size does: what the damping explains within two deviations is damping, all else is latency:

    f      = -(1 + kappa) y_a + kappa t_s y_a' - epsilon y_a'

    noise      sigma^2 += T/0.2 s (d^2/6 - sigma^2),   d = f(k) - 2 f(k-1) + f(k-2)
    slow       Kalman filter of (kappa_s, epsilon) on f and y_a after four poles at slow_prefilter w_1:
               F + A = -(A - t_s A') kappa_s - A' epsilon,
               R = sigma^2 + model_error^2 (A^2 + (A'/w_1)^2)
    adopted    epsilon_a -> epsilon within 0.1 cycles while the linear model fits and epsilon is significant,
               -> 0 within 0.3 cycles otherwise
    fast       Kalman filter of kappa alone on f and y_a below prefilter_frequency, process variance from its
               own innovations: a stiffness that varies with time, a rope that softens
    lead       f_l = f + T_f_hat f',  y_l = y_a + T_f_hat y_a'           the same backward difference in both
               r = f_l + (1 + kappa) y_l + (epsilon_a - kappa t_s) y_l'
    latency    l -> w_T epsilon as epsilon_a does,
               w_T = tol_latency^2/(tol_latency^2 + (damping_tolerance t_s)^2)
               in doubt w_T = 0 where exp(-2 damping_tolerance) < 1 + epsilon/t_s < exp(2 damping_tolerance),
               else 1; tol_latency = 0.3 T_f_hat, or 0.5 ms without lag
    force      f_comp = -(1 + kappa) y_d - (epsilon_a - l - kappa t_s) y_d' + r + f_e
               where f_comp is late on its way to the mass, y_d is y_d + force_delay y_d'
    share      r in two bands, split at 3 Hz, each by how much of its variance is not noise; the upper one
               only where sigma is above 1 % of the force
    undone     the motion that a wrong latency has made, x_t: m_s x_t'' = y_l' - k x_t - c x_t';
               a change d of l adds d (x_t, x_t') to the error (e, e') to be taken back,
               f_e = m_s (w_c^2 e + 2 w_c e') - k e - c e',   e'' = -w_c^2 e - 2 w_c e',   w_c = 1/retro_time
    command    u = s + d_1 v + d_2 a + d_3 j,   a = f_comp/m_s, or a_des where other forces act on the mass,
               exp(advance s)/M(s) = 1 + d_1 s + d_2 s^2 + d_3 s^3 + ...
               s_cmd = u + g u + h u', or u + g s + h s' with the plant's error `parallel`; (g, h) by a
               Kalman filter on s_cmd and s_act after four poles at plant_prefilter w_1

A sensor lag that is as believed and a contact that is as believed make r exactly 0.

Inputs   s_des, s_act, x [m], f_mea [N], v_des [m/s], a_des [m/s2]      used: s_des, s_act, x, f_mea
Outputs  f_comp [N], s_cmd [m]
States   all sampled, steady in the inputs at the start; kappa = epsilon = g = h = 0
Source   Kalman filters and prefilters: Ljung, System Identification (1999), Sec. 11. The contact model:
         paper, Eqs. 11, 15. The combination is the project's own.
Valid    One axis. Where a stiffness varies with time and the lag of the sensor is not as believed, the
         linear model no longer fits and the latency stays as believed.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Any, NamedTuple

from ..compensator.difference import process_parameters
from ..docking_contact.equations import PARAMETERS as CONTACT_PARAMETERS
from ..framework.arithmetic import Arithmetic
from ..framework.model import Linear, Model, SlotFunction, Values, no_effect
from ..framework.variables import Variable, choice, declare, parameter, sampled, state, switch, vector
from .plant import M_S, PLANT, T_F_HAT, USES_A_DES, acceleration, four_poles, inverse
from .plugs import INPUTS, OUTPUTS, SAMPLE_TIME, TERMINALS

BILINEAR = 0.5
NOISE_TIME = 0.2
"""Memory of the noise estimate [s]."""
SHARE_FREQUENCY = 3.0
"""Where the residual is split in two bands [Hz]."""
SLOW_SHARE_TIME = 0.5
FAST_SHARE_TIME = 0.05
"""Memory of the variance in the upper and in the lower band [s]."""
LOW_SHARE = 8.0
HIGH_SHARE = 4.0
"""Variance of a band in terms of its noise at which half of it is taken."""
LEAST_NOISE = 1e-4
"""Variance of the noise in terms of that of the force below which the upper band is taken whole: (1 %)^2."""
INNOVATION_TIME = 0.05
"""Memory of the size of the innovations [s]."""
ADOPTION_CYCLES = 0.1
RELEASE_CYCLES = 0.3
LATENCY_DRIFT = 1e-4
"""Process variance of epsilon [1/s], in terms of its prior variance."""
NOISE_IN_FIT = 0.05
LEAST_STIFFNESS = -0.95
LARGEST_STIFFNESS = 2.0
LAG_TOLERANCE = 0.3
DAMPING_DEVIATIONS = 2.0
"""Deviations of the damping within which an error of time is put down to it, if in doubt."""
STAYS_LATENCY = 0.8
"""Share of these limits below which what was a latency is one no more."""
LATENCY_WITHOUT_LAG = 5e-4
TINY = 1e-30


class Contact(IntEnum):
    """What is between the motion and the force."""

    docking = 1
    direct = 2


class PlantError(IntEnum):
    """Where the inverse 1/M of the plant is wrong: (1 + g + h s)/M, or 1/M + g + h s."""

    series = 1
    parallel = 2


PARAMETERS = declare(
    [v for v in CONTACT_PARAMETERS if not v.name.startswith("k_p_")],
    M_S,
    T_F_HAT,
    PLANT,
    USES_A_DES,
    choice("contact", Contact.docking, "Whether the contact is G(s), or k_m and c_m alone"),
    parameter(
        "force_delay",
        0.0,
        "s",
        "Delay of f_comp on its way to the mass; y_d is taken that much ahead. In doubt 0",
        minimum=0.0,
    ),
    parameter(
        "advance",
        0.0,
        "s",
        "How much ahead of s_des the motion is to be, against a delay of the force. In doubt 0",
        minimum=0.0,
    ),
    parameter(
        "latency_tolerance",
        -1.0,
        "s",
        "Standard deviation of T_f_hat; 0: the sensor is right and the damping is wrong; 0.3 T_f_hat: the "
        "damping is right; -1: the damping is wrong where damping_tolerance explains what is seen, else the "
        "sensor. In doubt -1, after commissioning its deviation",
    ),
    parameter(
        "stiffness_tolerance",
        0.2,
        "1",
        "Standard deviation of the stiffness, as a share. In doubt larger",
        minimum=0.0,
    ),
    parameter(
        "damping_tolerance",
        0.2,
        "1",
        "Standard deviation of the logarithm of the contact damping. In doubt 0.2",
        minimum=0.0,
    ),
    parameter(
        "stiffness_rate",
        0.3,
        "1",
        "Change of the stiffness, as a share per square root of a second. In doubt 0.3; 0: it is constant",
        minimum=0.0,
    ),
    parameter(
        "slow_stiffness_rate",
        0.002,
        "1",
        "The same when the latency is identified. In doubt 0.002; 0.03 if it varies and T_f_hat is unsure",
        minimum=0.0,
    ),
    parameter(
        "noise_floor", 0.02, "N", "Least noise of the force. In doubt the sensor's resolution", above=0.0
    ),
    parameter(
        "encoder_noise",
        1e-6,
        "m",
        "Noise of s_act, for the identification of the plant. In doubt its resolution",
        above=0.0,
    ),
    parameter(
        "prefilter_frequency",
        10.0,
        "Hz",
        "Corner of the fast identification. In doubt 10; above the loop frequency",
        above=0.0,
    ),
    parameter(
        "slow_prefilter",
        2.5,
        "1",
        "Corner of the slow identification in terms of w_1. In doubt 2.5",
        above=0.0,
    ),
    parameter(
        "plant_prefilter",
        6.0,
        "1",
        "Corner of the plant's identification in terms of w_1. In doubt 6",
        above=0.0,
    ),
    parameter(
        "plant_gain_tolerance",
        0.1,
        "1",
        "Standard deviation of the gain of the motion simulator. In doubt 0.1; 0: as believed",
        minimum=0.0,
    ),
    parameter(
        "plant_lag_tolerance",
        0.01,
        "s",
        "Standard deviation of the lag of the motion simulator. In doubt 0.01; 0: as believed",
        minimum=0.0,
    ),
    choice(
        "plant_error",
        PlantError.series,
        "Inverse of the plant, (1 + g + h s)/M or 1/M + g + h s. In doubt series: all lags are off alike; "
        "parallel where single coefficients are, or where the motion has several frequencies",
    ),
    parameter(
        "model_error", 0.02, "1", "Share of the signals that no model explains. In doubt 0.02", minimum=0.0
    ),
    parameter(
        "fit_limit",
        5e-5,
        "1",
        "Unexplained share of the variance up to which the linear model fits",
        minimum=0.0,
    ),
    parameter("wait_cycles", 1.0, "1", "Cycles before a latency is adopted. In doubt 1", minimum=0.0),
    parameter("significance", 3.0, "1", "Standard deviations that a latency needs. In doubt 3", minimum=0.0),
    parameter(
        "retro_time", 0.1, "s", "Time in which past errors of the motion are undone. In doubt 0.1", above=0.0
    ),
    parameter(
        "innovation_limit",
        0.5,
        "1",
        "Size of innovations, 1 as expected, for the full stiffness_rate",
        above=0.0,
    ),
    switch(
        "adapts", True, "The models correct themselves; else all is as believed and the residual counts whole"
    ),
    switch(
        "half_first_force",
        False,
        "True where the spacecraft is semi_implicit: the first impulse is halved here",
    ),
    SAMPLE_TIME,
)


def _hidden(unit: str, **descriptions: str) -> list[Variable]:
    return [sampled(state(name, unit, text), hidden=True) for name, text in descriptions.items()]


MEMORY = declare(
    _hidden("m", s_des_1="s_des, k-1", s_act_1="s_act - x, k-1", s_d_1="s_des - x, k-1"),
    _hidden("m", s_d_2="s_des - x, k-2", s_act_2="s_act - x, k-2"),
    _hidden("N", f_1="f_mea, k-1", f_2="f_mea, k-2"),
    _hidden("N", y_d_1="y_d, k-1", y_d_2="y_d, k-2", y_0_1="y_0, k-1", y_0_2="y_0, k-2"),
    _hidden("N", y_a_1="y_a, k-1", y_l_1="y_l, k-1"),
    _hidden("N2", noise="Variance of the noise of f_mea"),
    vector(sampled(state("F", "N", "f_mea after the slow prefilter"), hidden=True), 4),
    vector(sampled(state("A", "N", "y_a after the slow prefilter"), hidden=True), 4),
    _hidden("1", kappa_s="Slow stiffness error", P_kk="Its variance"),
    _hidden(
        "s", epsilon="Error of time", adopted="Error of time that is adopted", P_ke="Covariance with kappa_s"
    ),
    _hidden("s", latency="Part of it that is put down to the sensor"),
    _hidden("1", is_latency="1 where the damping does not explain epsilon"),
    _hidden("s2", P_ee="Variance of epsilon"),
    _hidden("N2", unexplained="Mean square of the slow residual", explained="Mean square of the slow y_a"),
    _hidden("1", cycles="Cycles of the prior since the start", is_adopted="1 if a latency is adopted"),
    _hidden("m", x_t="Sensitivity of the motion to a latency, per s", e="Error of the motion to be undone"),
    _hidden("m/s", v_t="Rate of x_t", der_e="Rate of e"),
    vector(sampled(state("F_fast", "N", "f_mea after the fast prefilter, and its rate"), hidden=True), 2),
    vector(sampled(state("A_fast", "N", "y_a after the fast prefilter, and its rate"), hidden=True), 2),
    _hidden(
        "1", kappa="Fast stiffness error", P_fast="Its variance", innovation="Mean square of its innovations"
    ),
    _hidden("N", r_low="Residual below the split"),
    _hidden("N2", low_variance="Variance of the residual below the split", high_variance="and above it"),
    _hidden("m/s2", a_1="f_comp/m_s, k-1"),
    vector(sampled(state("S_cmd", "m", "s_cmd after the plant's prefilter"), hidden=True), 4),
    vector(sampled(state("S_act", "m", "s_act after the plant's prefilter"), hidden=True), 4),
    _hidden("m", S_1="Filtered s_act, k-1", S_2="Filtered s_act, k-2", S_3="Filtered s_act, k-3"),
    _hidden("1", g="Gain error of the plant", P_gg="Its variance"),
    _hidden("s", h="Lag error of the plant", P_gh="Covariance with g"),
    _hidden("s2", P_hh="Variance of h"),
    _hidden("1", has_started="1 after the first sampling instant"),
)


class Prior(NamedTuple):
    """
    What is believed before the run; w_1 [rad/s], t_s [s], k [N/m], variances, w_T = latency_share [1].

    `least` and `most` [s]: errors of time between which, in doubt, the damping explains them.
    """

    w_1: Any
    t_s: Any
    k: Any
    latency_variance: Any
    latency_share: Any
    least: Any
    most: Any


class Estimate(NamedTuple):
    """Two parameters with their covariance."""

    first: Any
    second: Any
    P_11: Any
    P_12: Any
    P_22: Any


class Regressors(NamedTuple):
    """What the two parameters multiply."""

    first: Any
    second: Any


def prior(p: Any, m: Arithmetic) -> Prior:
    """Return loop frequency, loss and stiffness of the prior, and what a time error is put down to."""
    K = p.k_m + p.k_p
    k = p.k_m * p.k_p / K
    root = m.sqrt(_larger(K * K - 4.0 * p.m_e * p.k_m * p.k_p / p.m_s, 0.0, m))
    w_1 = m.sqrt(2.0 * p.k_m * p.k_p / (p.m_s * (K + root)))
    t_s = p.c_m / p.k_m + p.c_p / p.k_p - (p.c_m + p.c_p) / K
    is_direct = p.contact == Contact.direct
    k = m.where(is_direct, p.k_m, k)
    w_1 = m.where(is_direct, m.sqrt(p.k_m / p.m_s), w_1)
    t_s = m.where(is_direct, p.c_m / p.k_m, t_s)
    automatic = m.where(p.T_f_hat > 0.0, LAG_TOLERANCE * p.T_f_hat, LATENCY_WITHOUT_LAG)
    latency = m.where(p.latency_tolerance < 0.0, automatic, p.latency_tolerance)
    damping = p.damping_tolerance * t_s
    variance = latency * latency + damping * damping
    factor = m.exp(DAMPING_DEVIATIONS * p.damping_tolerance)
    least = t_s * (1.0 / factor - 1.0)
    most = t_s * (factor - 1.0)
    return Prior(w_1, t_s, k, variance, latency * latency / (variance + TINY), least, most)


def estimated(old: Estimate, h: Regressors, z: Any, R: Any) -> Estimate:
    """Return the estimate after z = h_1 first + h_2 second + noise of variance R."""
    g1 = old.P_11 * h.first + old.P_12 * h.second
    g2 = old.P_12 * h.first + old.P_22 * h.second
    S = h.first * g1 + h.second * g2 + R
    innovation = (z - h.first * old.first - h.second * old.second) / S
    return Estimate(
        old.first + g1 * innovation,
        old.second + g2 * innovation,
        old.P_11 - g1 * g1 / S,
        old.P_12 - g1 * g2 / S,
        old.P_22 - g2 * g2 / S,
    )


def _larger(a: Any, b: Any, m: Arithmetic) -> Any:
    return m.where(a > b, a, b)


def _smaller(a: Any, b: Any, m: Arithmetic) -> Any:
    return m.where(a < b, a, b)


def _second_order(stages: Any, u: Any, w: Any, T: Any) -> tuple[Any, Any]:
    """Step a low-pass of damping 0.7: value and rate."""
    value, rate = stages
    rate = (rate + T * w * w * (u - value)) / (1.0 + T * 1.4 * w + T * T * w * w)
    return value + T * rate, rate


def _difference_equation(p: Any, y: tuple[Any, Any], s: tuple[Any, Any, Any], m: Arithmetic) -> Any:
    a, b, c, d, e = process_parameters(p, BILINEAR)
    docking = a * y[0] + b * y[1] + c * s[0] + d * s[1] + e * s[2]
    direct = p.k_m * s[0] + p.c_m * (s[0] - s[1]) / p.sample_time
    return m.where(p.contact == Contact.direct, direct, docking)


class Robust(Model):
    """Force and displacement method; see the file's head."""

    name = "robust"
    description = "Compensation by models of contact and plant that correct themselves"
    variables = declare(PARAMETERS, INPUTS, OUTPUTS, MEMORY)
    terminals = TERMINALS
    linear = (Linear("adapts", "false", "adaptation is not linear: contact and plant stay as believed"),)
    sample_time = "sample_time"

    def initial(self, x: Any, u: Any, p: Any, m: Arithmetic) -> Values:
        known = prior(p, m)
        s_d = u.s_des - u.x
        s_a = u.s_act - u.x
        y_d, y_0 = known.k * s_d, known.k * s_a
        f_comp = u.f_mea + (y_0 - y_d)
        return {
            **{"f_comp": f_comp, "s_cmd": u.s_des, "a_1": acceleration(f_comp, u, p, m)},
            **{"s_des_1": u.s_des, "s_d_1": s_d, "s_d_2": s_d, "s_act_1": s_a, "s_act_2": s_a},
            **{"f_1": u.f_mea, "f_2": u.f_mea, "F": (u.f_mea,) * 4, "F_fast": (u.f_mea, 0.0)},
            **{"y_d_1": y_d, "y_d_2": y_d, "y_0_1": y_0, "y_0_2": y_0, "y_a_1": y_0, "y_l_1": y_0},
            **{"A": (y_0,) * 4, "A_fast": (y_0, 0.0), "r_low": u.f_mea + y_0},
            **{"noise": p.noise_floor * p.noise_floor, "explained": y_0 * y_0, "unexplained": 0.0},
            **{"P_kk": p.stiffness_tolerance * p.stiffness_tolerance, "P_ee": known.latency_variance},
            **{"P_fast": p.stiffness_tolerance * p.stiffness_tolerance},
            **{
                "S_cmd": (u.s_act,) * 4,
                "S_act": (u.s_act,) * 4,
                "S_1": u.s_act,
                "S_2": u.s_act,
                "S_3": u.s_act,
            },
            **{"P_gg": p.plant_gain_tolerance * p.plant_gain_tolerance},
            **{"P_hh": p.plant_lag_tolerance * p.plant_lag_tolerance},
            **{"low_variance": (u.f_mea + y_0) * (u.f_mea + y_0), "high_variance": 0.0},
            **dict.fromkeys(("kappa_s", "epsilon", "adopted", "P_ke", "cycles", "is_adopted", "kappa"), 0.0),
            **{"latency": 0.0, "is_latency": 0.0},
            **dict.fromkeys(("x_t", "v_t", "e", "der_e", "innovation", "g", "h", "P_gh", "has_started"), 0.0),
        }

    def update(self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect) -> Values:
        T = p.sample_time
        known = prior(p, m)
        models, y_d, y_a, y_l = _models(x, u, p, m)
        noise = _noise(x, u, p, m)
        slow, eps = _latency(x, u.f_mea, y_a, noise, known, p, m)
        fast, kappa = _stiffness(x, u.f_mea, y_a, noise, eps, known, p, m)
        f_l = u.f_mea + p.T_f_hat * (u.f_mea - x.f_1) / T
        der_y_l = (y_l - x.y_l_1) / T
        der_y_d = (y_d - x.y_d_1) / T
        residual = f_l + (1.0 + kappa) * y_l + (eps - kappa * known.t_s) * der_y_l
        bands, less_noise = _without_noise(x, residual, noise, slow["explained"], p, m)
        r = m.where(p.adapts, less_noise, residual)
        sensed = m.where(known.latency_share > 0.0, der_y_l, 0.0)
        undone, f_e = _undone(x, slow["latency"] - x.latency, sensed, kappa, known, p)
        damping = eps - slow["latency"] - kappa * known.t_s
        is_halved = m.both(p.half_first_force, x.has_started == 0.0)
        ahead = y_d + p.force_delay * der_y_d
        f_comp = m.where(is_halved, 0.5, 1.0) * (r - (1.0 + kappa) * ahead - damping * der_y_d + f_e)
        return {
            **models,
            **slow,
            **fast,
            **bands,
            **undone,
            **_command(x, u, acceleration(f_comp, u, p, m), known, p, m),
            **{"f_comp": f_comp, "noise": noise, "has_started": 1.0},
        }


def _models(x: Any, u: Any, p: Any, m: Arithmetic) -> tuple[Values, Any, Any, Any]:
    """Return the memory of the contact models, and y_d, y_a, y_l [N]."""
    T = p.sample_time
    s_d = u.s_des - u.x
    s_a = u.s_act - u.x
    y_d = _difference_equation(p, (x.y_d_1, x.y_d_2), (s_d, x.s_d_1, x.s_d_2), m)
    y_0 = _difference_equation(p, (x.y_0_1, x.y_0_2), (s_a, x.s_act_1, x.s_act_2), m)
    has_lag = p.T_f_hat > 0.0
    q = m.where(has_lag, m.exp(-T / m.where(has_lag, p.T_f_hat, T)), 0.0)
    mean = p.T_f_hat / T * (1.0 - q)
    y_a = q * x.y_a_1 + (mean - q) * x.y_0_1 + (1.0 - mean) * y_0
    y_l = y_a + p.T_f_hat * (y_a - x.y_a_1) / T
    memory = {
        **{"s_d_1": s_d, "s_d_2": x.s_d_1, "s_act_1": s_a, "s_act_2": x.s_act_1},
        **{"y_d_1": y_d, "y_d_2": x.y_d_1, "y_0_1": y_0, "y_0_2": x.y_0_1, "y_a_1": y_a, "y_l_1": y_l},
        **{"f_1": u.f_mea, "f_2": x.f_1},
    }
    return memory, y_d, y_a, y_l


def _noise(x: Any, u: Any, p: Any, m: Arithmetic) -> Any:
    """Return the variance [N2] of the white noise of f_mea, from its second difference."""
    d = u.f_mea - 2.0 * x.f_1 + x.f_2
    variance = x.noise + p.sample_time / NOISE_TIME * (d * d / 6.0 - x.noise)
    return _larger(variance, p.noise_floor * p.noise_floor, m)


def _latency(x: Any, f: Any, y_a: Any, noise: Any, known: Prior, p: Any, m: Arithmetic) -> tuple[Values, Any]:
    """Return the memory of the slow identification, and the error of time [s] that is adopted."""
    T = p.sample_time
    share = 1.0 - m.exp(-p.slow_prefilter * known.w_1 * T)
    F = four_poles(x.F, f, share)
    A = four_poles(x.A, y_a, share)
    der_A = (A[3] - x.A[3]) / T
    level = A[3] * A[3] + der_A * der_A / (known.w_1 * known.w_1)
    h = Regressors(-(A[3] - known.t_s * der_A), -der_A)
    z = F[3] + A[3]
    variance = p.stiffness_tolerance * p.stiffness_tolerance
    P_kk = _smaller(x.P_kk + p.slow_stiffness_rate * p.slow_stiffness_rate * T, variance, m)
    P_ee = _smaller(x.P_ee + LATENCY_DRIFT * known.latency_variance * T, known.latency_variance, m)
    old = Estimate(x.kappa_s, x.epsilon, P_kk, x.P_ke, P_ee)
    new = estimated(old, h, z, noise + p.model_error * p.model_error * level)
    left = z - h.first * new.first - h.second * new.second
    w = T * known.w_1 / (2.0 * m.pi)
    unexplained = x.unexplained + w * (left * left - x.unexplained)
    explained = x.explained + w * (A[3] * A[3] - x.explained)
    cycles = x.cycles + w
    fits = unexplained < p.fit_limit * explained + NOISE_IN_FIT * noise
    needed = p.significance * m.where(x.is_adopted > 0.5, 0.5, 1.0)
    is_significant = new.second * new.second > needed * needed * new.P_22
    adopts = m.both(p.adapts, m.both(m.both(cycles > p.wait_cycles, fits), is_significant))
    rate = m.where(adopts, w / ADOPTION_CYCLES, w / RELEASE_CYCLES)
    adopted = x.adopted + rate * (m.where(adopts, new.second, 0.0) - x.adopted)
    limit = m.where(new.second > 0.0, known.most, known.least)
    limit = limit * m.where(x.is_latency > 0.5, STAYS_LATENCY, 1.0)
    is_latency = m.where(new.second * new.second > limit * limit, 1.0, 0.0)
    share = m.where(p.latency_tolerance < 0.0, is_latency, known.latency_share)
    latency = x.latency + rate * (m.where(adopts, share * new.second, 0.0) - x.latency)
    memory = {
        **{"F": F, "A": A, "kappa_s": new.first, "epsilon": new.second},
        **{"P_kk": new.P_11, "P_ke": new.P_12, "P_ee": new.P_22},
        **{"unexplained": unexplained, "explained": explained, "cycles": cycles},
        **{"adopted": adopted, "is_adopted": m.where(adopts, 1.0, 0.0)},
        **{"latency": latency, "is_latency": is_latency},
    }
    return memory, adopted


def _stiffness(
    x: Any, f: Any, y_a: Any, noise: Any, eps: Any, known: Prior, p: Any, m: Arithmetic
) -> tuple[Values, Any]:
    """Return the memory of the fast identification, and the stiffness error kappa [1]."""
    T = p.sample_time
    w = 2.0 * m.pi * p.prefilter_frequency
    F, der_F = _second_order(x.F_fast, f, w, T)
    A, der_A = _second_order(x.A_fast, y_a, w, T)
    h = -(A - known.t_s * der_A)
    z = F + A + eps * der_A
    level = A * A + der_A * der_A / (known.w_1 * known.w_1)
    R = noise + p.model_error * p.model_error * level
    rate = p.stiffness_rate * _smaller(1.0, x.innovation / p.innovation_limit, m)
    P = x.P_fast + rate * rate * T
    S = h * P * h + R
    innovation = z - h * x.kappa
    kappa = x.kappa + P * h / S * innovation
    kappa = m.where(p.adapts, _larger(_smaller(kappa, LARGEST_STIFFNESS, m), LEAST_STIFFNESS, m), 0.0)
    size = x.innovation + T / INNOVATION_TIME * (innovation * innovation / S - x.innovation)
    memory = {
        **{"F_fast": (F, der_F), "A_fast": (A, der_A), "kappa": kappa},
        **{"P_fast": P * R / S, "innovation": size},
    }
    return memory, kappa


def _without_noise(
    x: Any, residual: Any, noise: Any, explained: Any, p: Any, m: Arithmetic
) -> tuple[Values, Any]:
    """Return the memory of the two bands, and the residual [N] with as much of each as is not noise."""
    T = p.sample_time
    a = 1.0 - m.exp(-2.0 * m.pi * SHARE_FREQUENCY * T)
    low = x.r_low + a * (residual - x.r_low)
    high = residual - low
    lead = 1.0 + p.T_f_hat / T
    tail = a * (1.0 - a * lead)
    rest = (1.0 - a) * (1.0 - a)
    tails = tail * tail / (1.0 - rest)
    low_noise = noise * (a * a * lead * lead + tails)
    first, second = lead * (1.0 - a), lead - 1.0 + tail
    high_noise = noise * (first * first + second * second + rest * tails)
    low_variance = x.low_variance + T / FAST_SHARE_TIME * (low * low - x.low_variance)
    high_variance = x.high_variance + T / SLOW_SHARE_TIME * (high * high - x.high_variance)
    high_share = m.where(noise > LEAST_NOISE * explained, _share(high_variance, HIGH_SHARE * high_noise), 1.0)
    r = low * _share(low_variance, LOW_SHARE * low_noise) + high * high_share
    return {"r_low": low, "low_variance": low_variance, "high_variance": high_variance}, r


def _share(variance: Any, half: Any) -> Any:
    ratio = variance / half
    return ratio * ratio / (1.0 + ratio * ratio)


def _undone(x: Any, change: Any, der_y_l: Any, kappa: Any, known: Prior, p: Any) -> tuple[Values, Any]:
    """Return the memory of the retrospective correction, and its force f_e [N]."""
    T = p.sample_time
    k = (1.0 + kappa) * known.k
    c = known.t_s * known.k
    e = x.e + change * x.x_t
    der_e = x.der_e + change * x.v_t
    w = 1.0 / p.retro_time
    pull = w * w * e + 2.0 * w * der_e
    f_e = p.m_s * pull - k * e - c * der_e
    v_t = x.v_t + T * (der_y_l - k * x.x_t - c * x.v_t) / p.m_s
    der_e = der_e - T * pull
    memory = {"x_t": x.x_t + T * v_t, "v_t": v_t, "e": e + T * der_e, "der_e": der_e}
    return memory, f_e


def _command(x: Any, u: Any, a: Any, known: Prior, p: Any, m: Arithmetic) -> Values:
    """Return the command [m] and the memory of the plant's identification."""
    T = p.sample_time
    d = inverse(p)
    v = (u.s_des - x.s_des_1) / T + 0.5 * T * a
    j = (a - x.a_1) / T
    to = inverse(p, p.advance)
    is_parallel = p.plant_error == PlantError.parallel
    led = u.s_des + to.d1 * v + to.d2 * a + to.d3 * j
    der_led = v + to.d1 * a + to.d2 * j
    of_gain = m.where(is_parallel, u.s_des + p.advance * v, led)
    of_lag = m.where(is_parallel, v + p.advance * a, der_led)
    s_cmd = led + x.g * of_gain + x.h * of_lag
    share = 1.0 - m.exp(-p.plant_prefilter * known.w_1 * T)
    S_cmd = four_poles(x.S_cmd, s_cmd, share)
    S_act = four_poles(x.S_act, u.s_act, share)
    S = S_act[3]
    once = S - x.S_1
    twice = S - 2.0 * x.S_1 + x.S_2
    thrice = S - 3.0 * (x.S_1 - x.S_2) - x.S_3
    der_1 = (once + twice / 2.0 + thrice / 3.0) / T
    der_2 = (twice + thrice) / (T * T)
    der_3 = thrice / (T * T * T)
    w = S + d.d1 * der_1 + d.d2 * der_2 + d.d3 * der_3
    der_w = der_1 + d.d1 * der_2 + d.d2 * der_3
    level = w * w + der_w * der_w / (known.w_1 * known.w_1)
    gain_variance = p.plant_gain_tolerance * p.plant_gain_tolerance
    lag_variance = p.plant_lag_tolerance * p.plant_lag_tolerance
    P_gg = _smaller(x.P_gg + p.slow_stiffness_rate * p.slow_stiffness_rate * T, gain_variance, m)
    P_hh = _smaller(x.P_hh + LATENCY_DRIFT * lag_variance * T, lag_variance, m)
    R = p.encoder_noise * p.encoder_noise + p.model_error * p.model_error * level
    of_errors = Regressors(m.where(is_parallel, S, w), m.where(is_parallel, der_1, der_w))
    new = estimated(Estimate(x.g, x.h, P_gg, x.P_gh, P_hh), of_errors, S_cmd[3] - w, R)
    return {
        **{"s_cmd": s_cmd, "s_des_1": u.s_des, "a_1": a, "S_cmd": S_cmd, "S_act": S_act},
        **{"S_1": S, "S_2": x.S_1, "S_3": x.S_2},
        **{"g": m.where(p.adapts, new.first, 0.0), "h": m.where(p.adapts, new.second, 0.0)},
        **{"P_gg": new.P_11, "P_gh": new.P_12, "P_hh": new.P_22},
    }


MODEL = Robust()
