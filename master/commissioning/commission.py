"""
Commissioning: from a chirp with the spacecraft held to the parameters of a compensator, with deviations.

Motion simulator and contact with sensor are fitted apart; a delay of the force that the lag of the sensor
does not explain is in the model only where the record asks for it, and the force at rest only where its
zero is known and it is that of the stiffness that the chirp shows. What the fit leaves beyond the noise is
said: the rig then has something that the models lack, and the deviations are those of a wrong model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from .fit import Fit, Floats, Record, fit
from .models import (
    Knowledge,
    attributes,
    contact_form,
    contact_start,
    contact_starts,
    plant_form,
    plant_lag,
    plant_start,
    series_damping,
    series_stiffness,
)
from .rig import Held

LARGEST_RATIO = 1.5
"""What a fit may leave in terms of the noise without a warning."""
DELAY_GAIN = 12.0
"""Fall of the sum of squares, in terms of the noise, that a delay has to pay: 3.5 deviations."""
LARGEST_PULL = 3.0
"""Deviations by which a ratio may be other than believed without a warning."""
FORCE_SWING_IN_NOISE = 10.0


@dataclass(frozen=True)
class Value:
    """A parameter, its standard deviation, and their unit."""

    name: str
    value: float
    deviation: float
    unit: str
    meaning: str

    def as_dict(self) -> dict[str, Any]:
        """Fields for JSON."""
        return {"value": self.value, "deviation": self.deviation, "unit": self.unit}


@dataclass(frozen=True)
class Commissioned:
    """What a rig is, as far as its record tells."""

    values: tuple[Value, ...]
    plant: Fit
    contact: Fit
    m_e: float
    swing: float
    warnings: tuple[str, ...]

    def __getitem__(self, name: str) -> Value:
        return next(value for value in self.values if value.name == name)

    def parameters(self) -> dict[str, float]:
        """Return what a compensator is told, by its parameters; deviations are its tolerances."""
        k, c = self["k"], self["c"]
        late = self["delay"].value
        told = {
            name: self[name].value for name in ("k_m", "c_m", "k_p", "c_p", "K_p", "w_v", "z", "dead_time")
        }
        T_f_hat = self["T_f"].value + late
        lag = self["lag"]
        return {
            **told,
            "m_e": self.m_e,
            "T_f_hat": T_f_hat,
            "stiffness": k.value,
            "damping": c.value,
            "lag": lag.value,
            "latency": lag.value + T_f_hat,
            "latency_tolerance": float(np.hypot(self["T_f"].deviation, self["delay"].deviation)),
            "stiffness_tolerance": k.deviation / k.value,
            "damping_tolerance": c.deviation / c.value,
            "plant_gain_tolerance": self["gain"].deviation,
            "plant_lag_tolerance": lag.deviation,
            "noise_floor": self.contact.noise,
        }


def commission(
    held: Held, believed: Mapping[str, float], highest: float, knowledge: Knowledge
) -> Commissioned:
    """
    Fit a record.

    Args:
        held: The record.
        believed: Contact, `T_f` and motion simulator to start from; m_e is kept.
        highest: Frequency [Hz] up to which the record is used.
        knowledge: What is known besides.
    """
    plant = fit(
        Record(held.s_cmd, held.s_act, held.period, highest), plant_form(held.period), [plant_start(believed)]
    )
    record = Record(held.s_act, held.f_mea, held.period, highest)
    seen = _contact(record, believed, knowledge)
    contact = seen.fit
    swing = float(np.max(np.abs(held.f_mea - np.mean(held.f_mea))))
    values = (*_of_plant(plant), *_of_contact(contact, contact_start(believed), seen.has_delay))
    return Commissioned(values, plant, contact, believed["m_e"], swing, tuple(_warnings(plant, seen, swing)))


class _Contact(NamedTuple):
    """Fit of contact and sensor; the force at rest against what the chirp alone shows, in deviations."""

    fit: Fit
    has_delay: bool
    pull_at_rest: float


def _contact(record: Record, believed: Mapping[str, float], knowledge: Knowledge) -> _Contact:
    """Return the fit, with the force at rest if its zero is known and it does not contradict the chirp."""
    of_chirp, has_delay = _of_chirp(record, believed, knowledge)
    if not np.isfinite(knowledge.force_zero):
        return _Contact(of_chirp, has_delay, 0.0)
    known = replace(record, zero=knowledge.force_zero)
    form = contact_form(believed, knowledge, with_delay=has_delay)
    deviation = np.hypot(
        known.deviation_at_rest(of_chirp.noise),
        of_chirp.deviation(lambda theta: known.left_at_rest(form, theta)),
    )
    pull = known.left_at_rest(form, of_chirp.theta) / float(deviation)
    if abs(pull) > LARGEST_PULL:
        return _Contact(of_chirp, has_delay, pull)
    return _Contact(fit(known, form, [of_chirp.theta]), has_delay, pull)


def _of_chirp(record: Record, believed: Mapping[str, float], knowledge: Knowledge) -> tuple[Fit, bool]:
    """Return the fit without the force at rest, and whether it has a delay."""
    without = fit(
        record,
        contact_form(believed, knowledge, with_delay=False),
        contact_starts(believed, knowledge, with_delay=False),
    )
    start = np.array([*without.theta, 0.0])
    shared = np.array([*without.theta[:4], 0.5 * without.theta[4], without.theta[5], 0.5 * without.theta[4]])
    late = fit(record, contact_form(believed, knowledge, with_delay=True), [start, shared])
    scale = (without.noise / max(late.rms, late.noise)) ** 2
    if 2.0 * (without.cost - late.cost) * scale > DELAY_GAIN:
        return late, True
    return without, False


def _of_plant(found: Fit) -> list[Value]:
    def value(name: str, unit: str, meaning: str, of: Any) -> Value:
        return Value(name, float(of(found.theta)), found.deviation(of), unit, meaning)

    return [
        value("K_p", "1/s", "gain of the position loop", lambda p: np.exp(p[0])),
        value("w_v", "rad/s", "natural frequency of the velocity loop", lambda p: np.exp(p[1])),
        value("z", "1", "damping ratio of the velocity loop", lambda p: np.exp(p[2])),
        value("dead_time", "s", "dead time of the command", lambda p: p[3]),
        value("gain", "1", "displacement per command, at rest", lambda p: p[4]),
        value("lag", "s", "lag of the motion simulator at rest, dead time included", plant_lag),
    ]


def _of_contact(found: Fit, believed: Floats, has_delay: bool) -> list[Value]:
    def value(name: str, unit: str, meaning: str, of: Any) -> Value:
        return Value(name, float(of(found.theta)), found.deviation(of), unit, meaning)

    def contact(p: Floats) -> Floats:
        return attributes(p, believed)

    return [
        value("k_m", "N/m", "stiffness of the manipulator", lambda p: contact(p)[0]),
        value("k_p", "N/m", "stiffness of the rope", lambda p: contact(p)[1]),
        value("c_m", "N s/m", "damping of the manipulator", lambda p: contact(p)[2]),
        value("c_p", "N s/m", "damping of the rope", lambda p: contact(p)[3]),
        value("k", "N/m", "stiffness of the whole contact", lambda p: series_stiffness(contact(p))),
        value("c", "N s/m", "damping of the whole contact", lambda p: series_damping(contact(p))),
        value("T_f", "s", "time constant of the force sensor", lambda p: p[4]),
        value(
            "delay", "s", "delay of the force beyond the sensor's lag", lambda p: p[6] if has_delay else 0.0
        ),
    ]


def _warnings(plant: Fit, seen: _Contact, swing: float) -> list[str]:
    found = []
    contact = seen.fit
    for what, one, unit in (("s_cmd to s_act", plant, "m"), ("s_act to f_mea", contact, "N")):
        if one.ratio > LARGEST_RATIO:
            found.append(
                f"{what}: the fit leaves {one.rms:.3g} {unit}, {one.ratio:.2g} times the noise of "
                f"{one.noise:.3g} {unit}: the rig has what the model lacks, and "
                "deviations are too small (dockloop diagnose)"
            )
    for what, place in (("k_m/k_p", 1), ("c_m/c_p", 3)):
        if abs(contact.pulled[place]) > LARGEST_PULL:
            found.append(
                f"{what}: {contact.pulled[place]:+.1f} of its deviations from what is believed; expected "
                "another belief, or a ratio that is known less well"
            )
    if swing < FORCE_SWING_IN_NOISE * contact.noise:
        found.append(
            f"the force swings by {swing:.3g} N over a noise of {contact.noise:.3g} N: a larger or longer "
            "chirp tells more"
        )
    if abs(seen.pull_at_rest) > LARGEST_PULL:
        found.append(
            f"the force at rest is {seen.pull_at_rest:+.1f} deviations from that of the stiffness found, and "
            "is left out: expected a zero that is known less well, or displacements from where the contact "
            "bears nothing; a stiffness that depends on the force shows like this, too"
        )
    if seen.has_delay:
        found.append(
            "the force is late by more than the sensor's lag: T_f_hat is the sum of both, for want of a "
            "parameter of its own"
        )
    return found
