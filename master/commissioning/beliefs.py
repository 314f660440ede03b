"""What a configuration believes of its rig before it is measured: where a fit starts."""

from __future__ import annotations

from master import catalogue
from master.comparison.methods import PAPER
from master.experiment.experiment import Experiment

from .box import CONTACT, PLANT, SENSOR

FROM_COMPENSATOR = {"T_f": "T_f_hat"}
CONTACT_NAMES = ("m_e", "k_m", "c_m", "k_p", "c_p")
PLANT_NAMES = ("K_p", "w_v", "z", "dead_time")


def beliefs(experiment: Experiment) -> dict[str, float]:
    """
    Return contact, `T_f` and motion simulator as the compensator has them, else as their models begin.

    Nothing is taken from the FMUs that are the rig: a fit that starts at the truth shows nothing.
    """
    found = {name: catalogue.parameters(CONTACT)[name] for name in CONTACT_NAMES}
    found |= {name: catalogue.parameters(PLANT)[name] for name in PLANT_NAMES}
    found["T_f"] = catalogue.parameters(SENSOR)["T_f"]
    known = (PAPER, *catalogue.compensation_methods())
    for name, entry in experiment.config.fmus.items():
        if catalogue.base_model(entry.source) not in known:
            continue
        instance = experiment.system.instances[name]
        for key in found:
            own = FROM_COMPENSATOR.get(key, key)
            if own in instance.description.by_name:
                value = instance.value_of(own)
                found[key] = float(value if isinstance(value, int | float) else found[key])
    return found
