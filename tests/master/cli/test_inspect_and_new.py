"""`inspect` says what an FMU says; `new` guesses connections, and marks each guess."""

from __future__ import annotations

import json
import re
import zipfile

import pytest
from click.testing import CliRunner

from master.cli import COMMANDS, GROUPS, main

PLANT = ("spacecraft", "motion_simulator_linear", "docking_contact", "force_sensor", "compensator")


def call(*arguments):
    result = CliRunner().invoke(main, list(map(str, arguments)))
    assert result.exception is None or isinstance(result.exception, SystemExit), result.exception
    return result


def test_inspect_shows_each_variable_with_unit_start_and_items():
    found = json.loads(call("inspect", "spacecraft", "--json").stdout)
    by_name = {v["name"]: v for v in found["variables"]}

    assert (by_name["m_s"]["unit"], by_name["m_s"]["start"]) == ("kg", 820.0)
    assert by_name["integrator"]["start"] == "semi_implicit"
    assert by_name["integrator"]["items"] == {
        "semi_implicit": 1,
        "zero_order_hold": 2,
        "explicit_euler": 3,
        "leapfrog": 4,
    }
    assert found["capabilities"]["canGetAndSetFMUstate"] is True
    assert "linux64" in found["platforms"]
    assert found["odd"] == []


def test_inspect_says_what_is_odd(tmp_path):
    description = """\
<fmiModelDescription fmiVersion="2.0" modelName="odd" guid="x">
  <CoSimulation modelIdentifier="odd" needsExecutionTool="true"/>
  <ModelVariables>
    <ScalarVariable name="u" valueReference="0" causality="input">
      <Real start="0" unit="furlong"/>
    </ScalarVariable>
    <ScalarVariable name="y" valueReference="1" causality="output"><Real/></ScalarVariable>
  </ModelVariables>
  <ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""
    with zipfile.ZipFile(tmp_path / "odd.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.writestr("binaries/win64/odd.dll", b"")
    odd = "\n".join(json.loads(call("inspect", tmp_path / "odd.fmu", "--json").stdout)["odd"])

    assert "no binary for this platform, got win64" in odd
    assert "needs another program" in odd
    assert "cannot save its state" in odd
    assert "names units without defining them: u" in odd
    assert "has no unit for y" in odd


def test_a_draft_of_the_docking_loop_is_valid_and_marks_every_guess(tmp_path):
    file = tmp_path / "loop.yaml"
    assert call("new", *PLANT, "--output", file).exit_code == 0
    text = file.read_text(encoding="utf-8")
    wires = re.findall(r'from: "(\S+)", to: "(\S+)"', text)

    assert ("force_sensor.f_mea", "compensator.f_mea") in wires
    assert ("compensator.s_cmd", "motion_simulator_linear.s_cmd") in wires
    assert all("# guess: " in line for line in text.splitlines() if line.startswith("  - {from"))
    assert "# not connected: spacecraft.f [N]; outputs that fit: docking_contact.f_act" in text
    assert call("check", file).exit_code == 0


def test_terminals_of_one_kind_are_joined_whatever_their_members_are_called(tmp_path):
    def write(name, variable, causality, other):
        about = f'causality="{causality}"' + (' start="0"' if causality == "input" else "")
        description = f"""\
<fmiModelDescription fmiVersion="3.0" modelName="{name}" instantiationToken="x">
  <CoSimulation modelIdentifier="{name}"/>
  <ModelVariables>
    <Float64 name="{variable}" valueReference="1" {about}/>
    <Float64 name="{other}" valueReference="2" {about}/>
  </ModelVariables>
  <ModelStructure/>
</fmiModelDescription>
"""
        terminals = f"""\
<fmiTerminalsAndIcons fmiVersion="3.0"><Terminals>
  <Terminal name="plug" matchingRule="plug" terminalKind="org.example.force">
    <TerminalMemberVariable variableName="{variable}" memberName="force" variableKind="signal"/>
  </Terminal>
</Terminals></fmiTerminalsAndIcons>
"""
        with zipfile.ZipFile(tmp_path / f"{name}.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", description)
            archive.writestr("terminalsAndIcons/terminalsAndIcons.xml", terminals)

    write("rope", "pull", "output", "stretch")
    write("mass", "load", "input", "kick")
    call("new", tmp_path / "rope.fmu", tmp_path / "mass.fmu", "--output", tmp_path / "s.yaml")
    text = (tmp_path / "s.yaml").read_text(encoding="utf-8")

    assert '{from: "rope.pull", to: "mass.load"}    # guess: terminals of kind org.example.force' in text
    assert "not connected: mass.kick" in text
    assert 'source: "rope.fmu"' in text


def test_a_draft_replaces_nothing(tmp_path):
    (tmp_path / "s.yaml").write_text("mine", encoding="utf-8")
    result = call("new", "spacecraft", "--output", tmp_path / "s.yaml")

    assert result.exit_code == 2
    assert (tmp_path / "s.yaml").read_text(encoding="utf-8") == "mine"


def test_all_missing_fmus_are_said_at_once(tmp_path):
    result = call("new", "nothing", tmp_path / "no.fmu", "--output", tmp_path / "s.yaml")

    assert result.exit_code == 2
    assert "'nothing'" in result.stderr
    assert "no.fmu" in result.stderr


def test_help_lists_each_command_in_one_group_with_its_whole_summary():
    text = call("--help").stdout

    assert sorted(name for names in GROUPS.values() for name in names) == sorted(COMMANDS)
    assert "..." not in text.partition("Commands")[2]
    assert "what was computed" not in text
    assert (
        "Validate CONFIG, a system or a case: every fault at once, or one line that says what is in it."
        in " ".join(text.split())
    )


@pytest.mark.parametrize("name", ["low_frequency", "measured/first_case", "first_case", "hexapod/drag.yaml"])
def test_an_example_is_copied_with_all_that_it_names(tmp_path, name):
    assert call("examples", name, "--output", tmp_path).exit_code == 0
    [copied] = (
        tmp_path.rglob("*.yaml")
        if "first" in name or name == "low_frequency"
        else [*tmp_path.rglob("drag.yaml")]
    )

    schema = copied.read_text(encoding="utf-8").partition("\n")[0].partition("$schema=")[2]
    assert (copied.parent / schema).is_file()
    again = call("examples", name, "--output", tmp_path)
    assert again.exit_code == 2
    assert "is there already" in again.stderr


def test_an_unknown_example_is_told_what_is_near(tmp_path):
    result = call("examples", "low_frequenzy", "--output", tmp_path)

    assert result.exit_code == 2
    assert "as low_frequency" in result.stderr
    assert not list(tmp_path.iterdir())
