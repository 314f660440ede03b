"""The paper's misprints and inconsistencies, what is right, and how that was verified."""

from __future__ import annotations

from dataclasses import dataclass

SYMBOLIC = "derived with a computer algebra system"
SIMULATED = "shown by simulation"
READ = "by reading"


@dataclass(frozen=True)
class Erratum:
    """One erratum: place, what is printed, what is right, how it was verified."""

    place: str
    printed: str
    correct: str
    verified: str


ERRATA = (
    Erratum("Eq. 7", "c_p (s_act - x_d')", "c_p (s_act' - x_d')", "dimensions; Eq. 8 has the factor s"),
    Erratum("Eqs. 11-13", "m_s s^2 in the denominator", "m_e s^2", f"{SYMBOLIC} from Eqs. 8 and 10"),
    Erratum(
        "Eqs. 11-13",
        "a plus in front",
        "a minus: the force is restoring, F_act = -G (S_act - X)",
        f"{SYMBOLIC}; with the plus the loop has a real pole at +6.06 1/s in case S1",
    ),
    Erratum("Eq. 16", "numerator of b equals its denominator: b = -1", "b = -m_e/D0", SYMBOLIC),
    Erratum(
        "Eq. 16",
        "signs of c, d, e for +G",
        "for data with f = -G s all three change sign; here c, d, e are those for -s",
        SYMBOLIC,
    ),
    Erratum(
        "Text of Eq. 15",
        "the identified force is the one after CFDC",
        "it is the one after FMDC; else another transfer is identified",
        READ,
    ),
    Erratum(
        "Secs. IV-B.1, V-A.2",
        "two lists of difference methods: differential, zero-order hold, bilinear; forward, "
        "backward, bilinear",
        "the second is what Sec. V uses",
        READ,
    ),
    Erratum("Eq. 17, text", "Delta f_act; Delta s_dev(k-2) twice", "Delta f_dev; (k-1) and (k-2)", READ),
    Erratum("Eq. 19", "Y(k+1) = Phi Y(k+1) + Gamma W", "Y(k+1) = Phi Y(k) + Gamma W", READ),
    Erratum(
        "Eq. 19, text",
        "W is measurement and V process noise",
        "by their places W is process and V measurement noise: Q = cov(W), R = cov(V)",
        READ,
    ),
    Erratum(
        "Eq. 21",
        "P(k,k-1) = P(k,k-1) + Q, after the gain",
        "P(k,k-1) = P(k-1,k-1) + Q, before the gain",
        READ,
    ),
    Erratum(
        "Sec. V-A.1",
        "Y(0) = [135 -428 350 -1.1 2.1]",
        "the order is e, d, c, b, a; it is unstable (poles 1.0 and 1.1) and has infinite "
        "static gain; no passive "
        "contact has exactly these c, d, e",
        SIMULATED,
    ),
    Erratum(
        "Sec. V-B",
        "a = 1.95, b = -1.01",
        "a = 1.994, b = -0.996: the printed pair has poles of modulus 1.005 at 39 Hz and a "
        "static stiffness of "
        "872 N/m, that is 0.15 Hz at 1000 kg; c, d, e are consistent with 0.87 Hz",
        SIMULATED,
    ),
    Erratum(
        "Eq. 3",
        "dynamics frequency",
        "that of the undamped two bodies; with the sensor on the frame side the loop has w^4 - (K/m_e) w^2 + "
        "k_m k_p/(m_s m_e) = 0, by 1.1 % higher for Table 3 at 1000 kg",
        f"{SYMBOLIC}; {SIMULATED}",
    ),
    Erratum(
        "Sec. III-A",
        "the inertia of the end-effector is negligible",
        "not for curves that shall coincide: 39 deg after ten cycles in Table 3",
        SIMULATED,
    ),
    Erratum(
        "Eqs. 22-24",
        "T is the time constant of the lead and the sampling time; K = 1/sqrt(alpha)",
        "two symbols; this K scales every static and ramp position, and does not correct the simulator's "
        "attenuation",
        f"{SIMULATED}: see the drag stage",
    ),
    Erratum("Sec. V-A", "R = 0.001", "a variance: sigma = 0.0316 N, 1e-4 of a 300 N amplitude", READ),
    Erratum(
        "Sec. IV-C",
        "DPDC alone still diverges",
        "only with more residual phase than 2 zeta0: with a sensor lag; see claim dpdc_alone_diverges",
        SIMULATED,
    ),
    Erratum(
        "Secs. II-B, V-A",
        "wire ropes; push and pull about zero force",
        "a rope only pulls; the oscillation needs a spring that acts both ways",
        READ,
    ),
    Erratum(
        "Sec. IV", "compensated force f_des equals f_des", "the first is the estimate of the second", READ
    ),
    Erratum(
        "Sec. III-A",
        "m_s is a few tons or tens of tons",
        "1000 kg in Sec. V-B; Y(0) with 0.97 Hz and m_e of at most 100 kg asks for less than 1.3 t",
        "estimate from the printed c, d, e",
    ),
)
