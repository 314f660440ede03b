"""Values of one FMU as a parameter set of SSP (.ssv), for any tool that sets start values."""

from __future__ import annotations

from collections.abc import Mapping

from lxml import etree

from .names import PREFIXES, ssv


def parameter_set(values: Mapping[str, float], name: str = "identifiedValues") -> str:
    """
    Write real values by the names of an FMU's variables, exactly.

    Source: System Structure and Parameterization 1.0, Modelica Association (2019), Sec. 6 (SSV).
    """
    root = etree.Element(ssv("ParameterSet"), version="1.0", name=name, nsmap={"ssv": PREFIXES["ssv"]})
    parameters = etree.SubElement(root, ssv("Parameters"))
    for key, value in values.items():
        parameter = etree.SubElement(parameters, ssv("Parameter"), name=key)
        etree.SubElement(parameter, ssv("Real"), value=repr(float(value)))
    return str(etree.tostring(root, xml_declaration=True, encoding="UTF-8", pretty_print=True), "utf-8")
