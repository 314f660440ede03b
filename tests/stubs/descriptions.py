"""A model description of FMI 2.0 with all that one can have, and an archive around any text."""

from __future__ import annotations

import zipfile
from pathlib import Path

XML = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="Rope" guid="{1}">
  <CoSimulation modelIdentifier="rope" canGetAndSetFMUstate="true"/>
  <UnitDefinitions>
    <Unit name="mm"><BaseUnit m="1" factor="0.001"/></Unit>
    <Unit name="degC"><BaseUnit K="1" offset="273.15"/></Unit>
  </UnitDefinitions>
  <TypeDefinitions>
    <SimpleType name="Method"><Enumeration>
      <Item name="kalman" value="1"/><Item name="rls" value="2"/>
    </Enumeration></SimpleType>
    <SimpleType name="Length"><Real unit="mm"/></SimpleType>
  </TypeDefinitions>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input" description="pull">
      <Real start="1.5" unit="mm" min="0" max="9" nominal="2"/></ScalarVariable>
    <ScalarVariable name="T" valueReference="1" causality="input">
      <Real start="20" unit="degC"/></ScalarVariable>
    <ScalarVariable name="x" valueReference="2" causality="output">
      <Real declaredType="Length"/></ScalarVariable>
    <ScalarVariable name="y" valueReference="3" causality="output"><Real unit="grade"/></ScalarVariable>
    <ScalarVariable name="n" valueReference="4" causality="output" variability="discrete">
      <Integer/></ScalarVariable>
    <ScalarVariable name="on" valueReference="5" causality="parameter" variability="fixed">
      <Boolean start="true"/></ScalarVariable>
    <ScalarVariable name="method" valueReference="6" causality="parameter" variability="fixed">
      <Enumeration declaredType="Method" start="2"/></ScalarVariable>
    <ScalarVariable name="label" valueReference="7" causality="output" variability="discrete">
      <String/></ScalarVariable>
    <ScalarVariable name="time" valueReference="8" causality="independent"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs>
    <Unknown index="3" dependencies="1"/><Unknown index="4"/><Unknown index="5" dependencies=""/>
    <Unknown index="8" dependencies=""/>
  </Outputs></ModelStructure>
</fmiModelDescription>
"""


def archive(folder: Path, xml: str, name: str = "modelDescription.xml") -> Path:
    """Pack a text as an FMU's description."""
    path = folder / "rope.fmu"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr(name, xml)
    return path
