"""Model descriptions of both versions with all that one can have, and an archive around any text."""

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

XML_3 = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="3.0" modelName="Rope" instantiationToken="{1}">
  <CoSimulation modelIdentifier="rope" canGetAndSetFMUState="true"/>
  <UnitDefinitions><Unit name="N"><BaseUnit kg="1" m="1" s="-2"/></Unit></UnitDefinitions>
  <TypeDefinitions><Float64Type name="Force" unit="N" min="0"/></TypeDefinitions>
  <ModelVariables>
    <Float64 name="time" valueReference="0" causality="independent" variability="continuous"/>
    <Float64 name="u" valueReference="1" causality="input" start="1 2"><Dimension start="2"/></Float64>
    <Float64 name="y" valueReference="2" causality="output" declaredType="Force"/>
    <UInt64 name="n" valueReference="3" causality="structuralParameter" variability="fixed" start="2"/>
    <Float32 name="z" valueReference="4" causality="output"><Dimension valueReference="3"/></Float32>
    <Boolean name="on" valueReference="5" causality="parameter" start="true"/>
  </ModelVariables>
  <ModelStructure><Output valueReference="2" dependencies="1"/></ModelStructure>
</fmiModelDescription>
"""


def archive(folder: Path, xml: str, name: str = "modelDescription.xml") -> Path:
    """Pack a text as an FMU's description."""
    path = folder / "rope.fmu"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr(name, xml)
    return path
