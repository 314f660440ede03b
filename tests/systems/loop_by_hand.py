"""The paper's loop stepped by hand on the FMUs of the release, through FMPy: no master."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from functools import cache
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.model_description import ModelDescription
from scipy.optimize import least_squares

from tests.conftest import PROJECT

T = 1e-3


@dataclass(frozen=True)
class Case:
    """One column of the parameter tables: masses, contact, start offset [m], T_f [s], f1 [Hz], lag [deg]."""

    m_s: float
    contact: dict
    s0: float
    T_f: float
    frequency: float
    lag: float
    zeta: float


LOW = {"m_e": 80.0, "k_m": 150e3, "c_m": 158.0, "k_p": 37.9e3, "c_p": 65.0}
HIGH = {"m_e": 60.0, "k_m": 8e5, "c_m": 800.0, "k_p": 4e5, "c_p": 400.0}
EXPERIMENT = {"m_e": 100.0, "k_m": 139.2e3, "c_m": 136.1, "k_p": 37.76e3, "c_p": 97.3}
CASES = {
    "S1": Case(820.0, LOW, -0.01, 0.0, 0.9746, 12.39, 0.00486),
    "S2": Case(1000.0, HIGH, -0.01, 0.0, 2.617, 33.20, 0.00822),
    "E1": Case(4000.0, EXPERIMENT, -0.005, 0.01, 0.4346, 5.53, 0.00306),
    "E2": Case(1000.0, EXPERIMENT, -0.005, 0.01, 0.8749, 11.13, 0.00619),
}
OFF = {"cfdc": False, "fmdc": False, "dpdc": False}


def compensation(case: str, *parts: str, **more) -> dict:
    """Switch on the named parts; FMDC only where the sensor has a lag."""
    wanted = [part for part in parts if part != "fmdc" or CASES[case].T_f > 0]
    return OFF | dict.fromkeys(wanted, True) | more


class Subsystem:
    """An FMU of the release; variables are set and read by name, SI."""

    def __init__(self, name: str, **values: Any) -> None:
        description, folder = _unpacked(name)
        self._variables = {v.name: v for v in description.modelVariables}
        self._fmu = FMU2Slave(
            guid=description.guid,
            modelIdentifier=description.coSimulation.modelIdentifier,
            unzipDirectory=folder.name,
            instanceName=name,
        )
        self._fmu.instantiate()
        self._fmu.setupExperiment(startTime=0.0)
        self._fmu.enterInitializationMode()
        for variable, value in values.items():
            self[variable] = value

    def __setitem__(self, name: str, value: Any) -> None:
        v = self._variables[name]
        number = value.value if isinstance(value, Enum) else value
        kind = "Integer" if v.type == "Enumeration" else v.type
        getattr(self._fmu, f"set{kind}")([v.valueReference], [number])

    def __getitem__(self, name: str) -> float:
        [value] = self._fmu.getReal([self._variables[name].valueReference])
        return value

    def initialise(self) -> None:
        """End the initialisation; outputs can be read before as well."""
        self._fmu.exitInitializationMode()

    def step(self, t: float, h: float) -> None:
        """Step from t to t + h [s]."""
        self._fmu.doStep(t, h)

    def close(self) -> None:
        """Free the instance."""
        self._fmu.terminate()
        self._fmu.freeInstance()


@cache
def _unpacked(name: str) -> tuple[ModelDescription, TemporaryDirectory[str]]:
    path = str(PROJECT / "fmus" / f"{name}.fmu")
    folder = TemporaryDirectory()
    extract(path, folder.name)
    return read_model_description(path), folder


def run(case: str, stop: float, switches: dict, *, amplitude: float = 0.0, **sensor) -> np.ndarray:
    """Step the loop; return s_des, s_act and the s of the real docking [m], shape (n + 1, 3)."""
    c = CASES[case]
    sensor = {"T_f": c.T_f, "sigma": 0.0316} | sensor
    lead = {"dpdc_phase": math.radians(c.lag), "dpdc_frequency": c.frequency}
    compensator = Subsystem("compensator", **c.contact, **lead, **switches)
    spacecraft = Subsystem("spacecraft", m_s=c.m_s, s_des=c.s0)
    simulator = Subsystem("motion_simulator_linear", s_act=c.s0, s_cmd=c.s0)
    contact = Subsystem("docking_contact", **c.contact, k_p_amplitude=amplitude, s_act=c.s0)
    force_sensor = Subsystem("force_sensor", **sensor)
    real = Subsystem("real_docking", m_s=c.m_s, s=c.s0, **c.contact, k_p_amplitude=amplitude)
    for one in (spacecraft, simulator, contact, real):
        one.initialise()
    force_sensor["f_act"] = contact["f_act"]
    force_sensor.initialise()
    _read(compensator, spacecraft, simulator, force_sensor)
    compensator.initialise()
    rows = [(c.s0, c.s0, c.s0)]
    for k in range(round(stop / T)):
        _read(compensator, spacecraft, simulator, force_sensor)
        compensator.step(k * T, T)
        spacecraft["f"] = compensator["f_des"]
        spacecraft.step(k * T, T)
        simulator["s_cmd"] = compensator["s_cmd"]
        simulator.step(k * T, T)
        contact["s_act"], contact["v_act"] = simulator["s_act"], simulator["v_act"]
        contact.step(k * T, T)
        force_sensor["f_act"] = contact["f_act"]
        force_sensor.step(k * T, T)
        real.step(k * T, T)
        rows.append((spacecraft["s_des"], simulator["s_act"], real["s"]))
        if abs(rows[-1][0]) > 1e3:
            break
    for one in (compensator, spacecraft, simulator, contact, force_sensor, real):
        one.close()
    return np.array(rows)


def _read(compensator, spacecraft, simulator, force_sensor) -> None:
    compensator["s_des"], compensator["s_act"] = spacecraft["s_des"], simulator["s_act"]
    compensator["f_mea"] = force_sensor["f_mea"]


@dataclass(frozen=True)
class Oscillation:
    """Fitted damping ratio, frequency [Hz] and complex amplitude."""

    zeta: float
    frequency: float
    amplitude: complex

    @property
    def growth(self) -> float:
        """Growth per cycle."""
        return math.exp(-2 * math.pi * self.zeta / math.sqrt(1 - self.zeta**2))


def oscillation(s: np.ndarray, frequency: float, start: float = 1.0) -> Oscillation:
    """Fit one growing or decaying oscillation from `start` [s] on."""
    t = T * np.arange(len(s))
    t, s = t[t > start], s[t > start]
    lag = round(1 / (6 * frequency * T))
    a, b, c = s[: -2 * lag], s[lag:-lag], s[2 * lag :]
    scale = 1 / np.sqrt(a * a + b * b + c * c)
    two_cos, square = np.linalg.lstsq(np.c_[b, a] * scale[:, None], c * scale, rcond=None)[0]
    radius = math.sqrt(-square)
    guess = np.array([math.log(radius), math.acos(two_cos / 2 / radius)]) / (lag * T)
    flat = s * np.exp(-guess[0] * t)

    def amplitude(q):
        waves = np.c_[np.cos(q[1] * t), np.sin(q[1] * t)] * np.exp((q[0] - guess[0]) * t)[:, None]
        return waves, np.linalg.lstsq(waves, flat, rcond=None)[0]

    def residual(q):
        waves, factors = amplitude(q)
        return (waves @ factors - flat) / np.abs(flat).max()

    q = least_squares(residual, guess, x_scale=[0.01, 0.1], diff_step=1e-6).x
    cos, sin = amplitude(q)[1]
    return Oscillation(-q[0] / math.hypot(*q), q[1] / (2 * math.pi), complex(cos, -sin))


def rms(s: np.ndarray, reference: np.ndarray, s0: float) -> float:
    """RMS of the difference relative to the start offset."""
    return float(np.sqrt(np.mean((s - reference) ** 2)) / abs(s0))
