"""The declarations of the compensator: parameters, inputs, states, outputs."""

from __future__ import annotations

from itertools import chain

from ..docking_contact.equations import PARAMETERS as CONTACT_PARAMETERS
from ..framework.variables import (
    choice,
    declare,
    fixed,
    input_,
    output,
    parameter,
    sampled,
    state,
    switch,
    vector,
)
from .difference import DifferenceMethod
from .identifiers.framework.catalogue import IdentifierChoice, listed
from .identifiers.framework.recursion import N_COVARIANCE
from .phase_lead import GainConvention
from .tuning import Preset

SWITCHES = declare(
    switch("fmdc", True, "Force measurement delay compensation (Eq. 14)"),
    switch("cfdc", True, "Contact force delay compensation (Eqs. 15-18)"),
    switch("dpdc", True, "Displacement phase delay compensation (Eqs. 22-24)"),
    choice("identifier", IdentifierChoice(1), "Source of the process parameters"),
    choice("preset", Preset.F, "Tuning of the identifier"),
    choice("difference_method", DifferenceMethod.backward, "Difference method of Eq. 15"),
    choice("gain_convention", GainConvention.paper, "Where the phase lead has gain dpdc_gain"),
)

PARAMETERS = declare(
    [v for v in CONTACT_PARAMETERS if not v.name.startswith("k_p_")],
    parameter("prior_gain", 0.95, "1", "Factor on c, d, e of the prior of kalman and rls"),
    parameter("P0_ab", 1e-2, "1", "Start variance of a, b", minimum=0.0),
    parameter("P0_cde", 1e-2, "N2/m2", "Start variance of c, d, e", minimum=0.0),
    parameter("Q_ab", 0.0, "1", "Process variance of a, b in one period", minimum=0.0),
    parameter("Q_cde", 0.0, "N2/m2", "Process variance of c, d, e in one period", minimum=0.0),
    parameter("R", 1e-3, "N2", "Measurement variance of the force", above=0.0),
    parameter("prefilter_frequency", 0.0, "Hz", "Cut-off of the prefilter, 0: none", minimum=0.0),
    chain.from_iterable(one.parameters for one in listed()),
    parameter("T_f_hat", 0.01, "s", "Assumed time constant of the force sensor", minimum=0.0),
    parameter("fmdc_filter", 0.0, "s", "Time constant of the filter pole of the force lead", minimum=0.0),
    parameter("dpdc_phase", 0.21625, "rad", "Phase lag to compensate, phi_max", minimum=0.0, maximum=1.5),
    parameter("dpdc_frequency", 0.9746, "Hz", "Frequency of that lag, f_max", above=0.0),
    switch("identification_held", False, "The identified process parameters stay as they are"),
    fixed(parameter("sample_time", 1e-3, "s", "Sampling period", above=0.0)),
    parameter("dpdc_gain", 1.0, "1", "Gain of the phase lead, at f_max or at rest", above=0.0),
)

INPUTS = declare(
    input_("s_des", "m", "Desired displacement of the spacecraft"),
    input_("s_act", "m", "Actual displacement of the motion simulator"),
    input_("f_mea", "N", "Measured contact force"),
    input_("x", "m", "Travel of the drag mechanism relative to the end-effector"),
    input_("v_des", "m/s", "Desired velocity of the spacecraft"),
    input_("a_des", "m/s2", "Desired acceleration of the spacecraft"),
)
"""Those of every method in `compensators`; v_des and a_des are not used here."""

PROCESS = declare(
    sampled(state("a", "1", "Process parameter on f(k-1)", output=True)),
    sampled(state("b", "1", "Process parameter on f(k-2)", output=True)),
    sampled(state("c", "N/m", "Process parameter on -s(k)", output=True)),
    sampled(state("d", "N/m", "Process parameter on -s(k-1)", output=True)),
    sampled(state("e", "N/m", "Process parameter on -s(k-2)", output=True)),
    sampled(state("f_lead", "N", "Force after the force measurement delay compensation", output=True)),
)

MEMORY = declare(
    *(
        sampled(state(name, unit, description), hidden=True)
        for name, unit, description in (
            ("last_f_mea", "N", "Measured force, k-1"),
            ("f_stage", "N", "First low-pass on the force"),
            ("f_1", "N", "Force for identification, k-1"),
            ("f_2", "N", "Force for identification, k-2"),
            ("s_stage", "m", "First low-pass on s_act - x"),
            ("s_1", "m", "Displacement for identification, k-1"),
            ("s_2", "m", "Displacement for identification, k-2"),
            ("dF_1", "N", "Contact force correction, k-1"),
            ("dF_2", "N", "Contact force correction, k-2"),
            ("ds_1", "m", "Displacement deviation, k-1"),
            ("ds_2", "m", "Displacement deviation, k-2"),
            ("last_s_des", "m", "Desired displacement, k-1"),
            ("led_command", "m", "Command after the phase lead, k-1"),
        )
    ),
    vector(sampled(state("P", "1", "Covariance, upper triangle"), hidden=True), N_COVARIANCE),
    chain.from_iterable(one.states for one in listed()),
)

OUTPUTS = declare(
    output("f_des", "N", "Compensated force to the spacecraft dynamics"),
    output("s_cmd", "m", "Command to the motion simulator"),
    output("df", "N", "Contact force correction"),
    output("m_e_id", "kg", "Recovered mass of end-effector and manipulator"),
    output("k_m_id", "N/m", "Recovered stiffness of the manipulator"),
    output("c_m_id", "N s/m", "Recovered damping of the manipulator"),
    output("k_p_id", "N/m", "Recovered stiffness of the rope"),
    output("c_p_id", "N s/m", "Recovered damping of the rope"),
    output("attributes_valid", "1", "1 if the recovered parameters are regular and physical, else 0"),
    output("f_comp", "N", "The same as f_des, by the name that all methods have for it"),
)
