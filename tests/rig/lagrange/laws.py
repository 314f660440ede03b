"""
Laws by name, in the rope, the guide, the sensor or the simulator; faults of the compensator.

`LAWS` are those that no listed effect contains, `LISTED` those that have a name, with the right ones.

`size` leaves some two to thirty times the noise of 0.5 N on the rig's motion. The equations are in
`plant.py`, where a law goes by its number.
"""

from __future__ import annotations

from dataclasses import dataclass

ROPE, GUIDE, SENSOR, SIMULATOR = "contact.rope", "contact.guide", "force_sensor", "motion_simulator"


@dataclass(frozen=True)
class Law:
    """
    A law with its number in the equations, its place, its typical size and what it is, in words.

    `names` are the listed effects that it is, none for a law that has no name.
    """

    name: str
    number: int
    place: str
    size: float
    words: str
    names: tuple[str, ...] = ()

    @property
    def subsystem(self) -> str:
        """The FMU that lacks it."""
        return self.place.partition(".")[0]


_ROWS = (
    ("bump", ROPE, 8.0, "a spring force around one elongation, A exp(-((r - 1 mm)/0.4 mm)^2)"),
    ("bistable", ROPE, 8.0, "a spring that pushes away from zero, A r/a ((r/a)^2 - 1) exp(-(r/a)^2/2)"),
    ("staircase", ROPE, 1.5, "a spring in three rounded steps"),
    ("exponential_spring", ROPE, 0.7, "A (exp(r/r0) - 1 - r/r0)"),
    ("centre_damping", ROPE, 700.0, "a damper near zero elongation alone"),
    ("one_way_damper", ROPE, 400.0, "a damper in one direction alone"),
    ("softening_in_time", ROPE, 0.03, "a stiffness that falls in proportion to time, share in 10 s"),
    ("chirped_stiffness", ROPE, 0.05, "a stiffness that swings faster and faster, share"),
    ("switching_stiffness", ROPE, 0.04, "a stiffness that jumps up and down at fixed odd times, share"),
    ("fatigue", ROPE, 0.3, "a stiffness that falls with the way travelled, share a metre"),
    ("lost_contact", ROPE, 0.6, "contact that is lost for 30 ms at odd times, share of the force"),
    ("energy_softening", ROPE, 0.15, "a stiffness that falls with the strain energy over its first 0.1 J"),
    ("fractional", ROPE, 500.0, "a damper of three arms in parallel: a fractional derivative"),
    ("position_damping", GUIDE, 300.0, "viscous friction that swings along the way"),
    ("tilted_friction", GUIDE, 6.0, "dry friction in proportion to the place, of either sign"),
    ("onset_of_drag", GUIDE, 500.0, "drag beyond a speed"),
    ("warming_friction", GUIDE, 8.0, "dry friction that falls with the heat it makes"),
    ("swinging_friction", GUIDE, 4.0, "dry friction that swings at 0.7 Hz"),
    ("forward_drag", GUIDE, 4000.0, "drag with the square of speed, forward alone"),
    ("late_friction", GUIDE, 5.0, "dry friction that follows the direction 15 ms late"),
    ("sticking_pulses", GUIDE, 10.0, "pulses against the motion at odd times"),
    ("two_grooves", GUIDE, 3.0, "two forces along the way, of incommensurable pitch"),
    ("accelerated_friction", GUIDE, 15.0, "dry friction in proportion to the size of the acceleration"),
    ("squared_reading", SENSOR, 1e-4, "a reading with a part in f |f|"),
    ("cubed_reading", SENSOR, 3e-7, "a reading with a part in f^3"),
    ("swinging_gain", SENSOR, 0.05, "a gain that swings at 0.9 Hz"),
    ("fading_gain", SENSOR, 0.1, "a gain that falls with 3 s, share"),
    ("pull_and_push", SENSOR, 0.06, "a gain that differs between pull and push"),
    ("frame_mode", SENSOR, 2.0, "a mode of the frame at 9 Hz, shaken by the platform, effective mass"),
    ("held_samples", SENSOR, 0.02, "samples that are held for 20 ms at odd times, share of the time"),
    ("speed_crosstalk", SENSOR, 80.0, "a part in the platform's velocity"),
    ("amplitude_lag", SENSOR, 2e-5, "a lag that grows with the force, s/N"),
    ("logarithmic", SENSOR, 0.05, "a reading that saturates like a logarithm"),
    ("direction_gain", SIMULATOR, 0.05, "a velocity loop that is weaker forward"),
    ("geometric_error", SIMULATOR, 4e-5, "a command that is off along the way, m"),
)

LAWS = {
    name: Law(name, number, place, size, words)
    for number, (name, place, size, words) in enumerate(_ROWS, start=1)
}

FIRST_LISTED = 101
_LISTED_ROWS = (
    ("cubic", ROPE, 2e8, "a spring force in r^3", ("cubic_stiffness",)),
    ("second_stage", ROPE, 9e3, "a spring that is touched beyond 1.2 mm", ("second_stage",)),
    ("swinging_stiffness", ROPE, 0.05, "a stiffness that swings at 1.8 Hz", ("parametric_stiffness",)),
    ("coulomb", GUIDE, 4.0, "dry friction", ("coulomb",)),
    ("quadratic_damping", GUIDE, 4e3, "drag with the square of speed", ("quadratic_damping",)),
    ("ripple", GUIDE, 3.0, "a force of 0.4 mm pitch", ("ripple",)),
    (
        "asymmetric",
        GUIDE,
        5.0,
        "dry friction, 40 % of it backward",
        ("asymmetric_friction", "coulomb", "offset"),
    ),
    ("dahl", GUIDE, 4.0, "dry friction over a way of 50 um", ("dahl",)),
    ("zero_error", SENSOR, 2.0, "a reading that is off", ("offset",)),
    ("drift", SENSOR, 0.3, "a reading that runs away", ("drift",)),
    ("limit", SENSOR, 90.0, "a reading that ends at a limit", ("force_saturation",)),
    ("steps", SENSOR, 3.0, "a reading in steps", ("quantisation",)),
)

LISTED = {
    name: Law(name, number, place, size, words, names)
    for number, (name, place, size, words, names) in enumerate(_LISTED_ROWS, start=FIRST_LISTED)
}

PAIRS = ("zero_error+second_stage", "coulomb+cubic", "drift+ripple", "limit+coulomb", "dahl+second_stage")

FAULTS = {
    "late_force": "one tick late",
    "wrong_sign": "has the other sign",
    "clipped": "is clipped",
    "rounded": "rounded",
    "wrong_lag": "instead of",
    "no_correction": "is missing",
    "stale_position": "held for 2 ticks",
}
"""Fault of the compensator to words that tell its kind."""
