import re
import zipfile

import numpy as np
import pytest

from master.errors import ConfigError, FmuError
from master.fmi.description_reader import read_description
from tests.foreign.build import FOLDERS, describe_2, describe_3, write_fmu
from tests.foreign.foreign import COMPILED, run, wires

pytestmark = COMPILED


@pytest.mark.parametrize("version", FOLDERS)
@pytest.mark.parametrize(("answer", "name"), [(2, "discard"), (3, "error")])
def test_a_status_ends_the_run_with_the_words_of_the_fmu(fmu, tmp_path, version, answer, name):
    fmu(version)
    parameters = {"answer": answer, "label": "rope torn"}
    fmus = {"a": {"source": f"./types{version[0]}.fmu", "parameters": parameters}}
    outcome = run(tmp_path, fmus)

    assert (outcome.status, outcome.steps, outcome.error.status) == ("failed", 2, name)
    answer = " (the step answered with status discard: it cannot do this)" if name == "discard" else ""
    assert str(outcome.error) == f"a at t=0.2 s: [status] rope torn{answer}"


END, END_WITHIN, EARLY, NO_PROGRESS, EVENTS = range(10, 15)  # requests of the test FMUs from 0.2 s on
ASKS = "asks for the end of the simulation, [status] rope torn"


@pytest.mark.parametrize(
    ("version", "answer", "rows", "at"),
    [("2.0", END, 3, "0.2"), ("3.0", END, 4, "0.3"), ("3.0", END_WITHIN, 3, "0.2")],
)
def test_an_fmu_may_end_the_simulation(fmu, tmp_path, version, answer, rows, at):
    """Rows of whole steps stay: the step at whose end it asks, but not one that it breaks off."""
    fmu(version)
    source = f"./types{version[0]}.fmu"
    fmus = {"a": {"source": source, "parameters": {"answer": answer, "label": "rope torn"}}}
    fmus |= {"b": {"source": source}}
    outcome = run(tmp_path, fmus)

    assert (outcome.status, outcome.error, len(outcome.result.time)) == ("terminated", None, rows)
    assert outcome.cause == f"a at t={at} s: {ASKS}"


def test_an_fmu_that_returns_early_is_stepped_on_to_the_communication_point(fmu, tmp_path):
    fmu("3.0")
    outcome = run(tmp_path, {"a": {"source": "./types3.fmu", "parameters": {"answer": EARLY}}})

    # half of what is left, three times, and the rest: four calls a step, counted on top of 2
    assert outcome.status == "completed"
    assert outcome.result["a.b[1,1]"].tolist() == [2.0, 2.0, 2.0, 6.0, 10.0, 14.0]


@pytest.mark.parametrize(
    ("answer", "problem"),
    [
        (NO_PROGRESS, "returned early from a step without getting on, expected the step's end"),
        (
            EVENTS,
            "asks for event mode, which it was not given, expected that it handles its events itself",
        ),
    ],
)
def test_an_answer_that_is_not_allowed_is_named(fmu, tmp_path, answer, problem):
    fmu("3.0")
    outcome = run(tmp_path, {"a": {"source": "./types3.fmu", "parameters": {"answer": answer}}})

    assert (outcome.status, outcome.steps) == ("failed", 2)
    assert str(outcome.error) == f"a at t=0.2 s: {problem}"


COSIMULATION = '<CoSimulation modelIdentifier="types"{}/>'
EVENT_MODE = COSIMULATION.format(' hasEventMode="true"')


def test_an_fmu_that_works_in_event_mode_only_is_led_through_its_events(fmu, tmp_path):
    fmu("3.0", describe_3(EVENT_MODE, token="events"))
    fmus = {"a": {"source": "./types3.fmu", "start": {"Int8_in": 7}}, "b": {"source": "./types3.fmu"}}
    outcome = run(tmp_path, fmus, wires(("a.Int8_out", "b.Int8_in")))

    assert outcome.status == "completed"
    assert outcome.result["b.Int8_out"][1:].tolist() == 5 * [7.0]
    # entered at the end of each step and at 0.15 s and 0.35 s; two updates after each, one before a step
    assert outcome.result["b.ib[1]"].tolist() == [0, 1, 3, 4, 6, 7]
    assert outcome.result["b.ib[2]"].tolist() == [2, 5, 10, 13, 18, 21]


def test_an_fmu_that_would_have_its_clocks_ticked_is_named(fmu, tmp_path):
    attributes = 'causality="input" intervalVariability="constant" intervalDecimal="0.1"'
    fmu("3.0", describe_3(EVENT_MODE, f'<Clock name="tick" valueReference="130" {attributes}/>', "events"))

    with pytest.raises(FmuError, match="with clocks that the master would have to tick: tick"):
        run(tmp_path, {"a": {"source": "./types3.fmu"}})


def test_an_fmu_that_needs_what_it_does_not_declare_says_so_itself(fmu, tmp_path):
    fmu("3.0", describe_3(token="events"))

    answer = r"\(fmi3InstantiateCoSimulation returned no instance\)"
    with pytest.raises(FmuError, match=rf"^a at t=0 s: \[status\] works in event mode only {answer}$"):
        run(tmp_path, {"a": {"source": "./types3.fmu"}})


NOT_EXCHANGED = """
    <Clock name="tick" valueReference="130" causality="input" intervalVariability="triggered"/>
    <Clock name="tock" valueReference="131" causality="output" intervalVariability="triggered"/>
    <Binary name="blob" valueReference="132" causality="output"/>
"""


@pytest.mark.parametrize(
    ("source", "target", "end", "what"),
    [
        ("a.tock", "b.Int8_in", "from", "a.tock (a clock)"),
        ("a.Int8_out", "b.tick", "to", "b.tick (a clock)"),
        ("a.blob", "b.Int8_in", "from", "a.blob (a binary)"),
    ],
)
def test_a_wire_that_is_not_supported_is_named(fmu, tmp_path, source, target, end, what):
    fmu("3.0", describe_3(EVENT_MODE, NOT_EXCHANGED))
    fmus = {name: {"source": "./types3.fmu"} for name in "ab"}
    with pytest.raises(ConfigError) as caught:
        run(tmp_path, fmus, wires((source, target)))

    [problem] = caught.value.problems
    assert re.search(rf"system\.yaml:\d+: connections\[0\]\.{end}: cannot be exchanged, got ", problem)
    assert what in problem


def test_a_start_value_of_a_clock_is_refused(fmu, tmp_path):
    fmu("3.0", describe_3(EVENT_MODE, NOT_EXCHANGED))
    with pytest.raises(ConfigError, match=r"start\.tick: cannot be set, got 'tick' \(a clock\)"):
        run(tmp_path, {"a": {"source": "./types3.fmu", "start": {"tick": True}}})


@pytest.mark.parametrize("version", FOLDERS)
def test_a_warning_does_not_end_the_run(fmu, tmp_path, version):
    fmu(version)
    fmus = {"a": {"source": f"./types{version[0]}.fmu", "parameters": {"answer": 1, "label": "warm"}}}

    assert run(tmp_path, fmus).status == "completed"


def test_an_fmu_with_event_mode_and_clocks_is_stepped_without_them(fmu, tmp_path):
    clock = '<Clock name="tick" valueReference="130" causality="input" intervalVariability="triggered"/>'
    flags = 'hasEventMode="true" canReturnEarlyAfterIntermediateUpdate="true"'
    interface = f'<CoSimulation modelIdentifier="types" {flags}/>'
    fmu("3.0", describe_3(interface, clock))
    outcome = run(tmp_path, {"a": {"source": "./types3.fmu"}})

    assert (outcome.status, np.shape(outcome.result.values)[0]) == ("completed", 6)


def test_an_archive_that_is_damaged_is_named(fmu, tmp_path):
    path = fmu("3.0")
    content = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as archive:
        [binary] = [i for i in archive.infolist() if i.filename.endswith(".so")]
    content[binary.header_offset + 200] ^= 255
    path.write_bytes(content)

    with pytest.raises(ConfigError, match=r"types3\.fmu: cannot be unpacked: binaries/.*: damaged, got "):
        run(tmp_path, {"a": {"source": "./types3.fmu"}})


def test_fmi_1_is_refused(tmp_path):
    path = write_fmu(tmp_path / "old.fmu", describe_2(version="1.0"), {})

    with pytest.raises(ConfigError, match=r"FMI version not supported, got '1\.0', expected 2\.0 or 3\.0"):
        read_description(path)


@pytest.mark.parametrize("describe", [describe_2, describe_3])
def test_an_fmu_for_model_exchange_only_is_refused(tmp_path, describe):
    path = write_fmu(tmp_path / "me.fmu", describe('<ModelExchange modelIdentifier="types"/>'), {})

    with pytest.raises(ConfigError, match="not for co-simulation, got an FMU for model exchange only"):
        read_description(path)


@pytest.mark.parametrize("version", FOLDERS)
def test_a_missing_binary_names_the_platform(tmp_path, version):
    text = describe_3() if version == "3.0" else describe_2()
    write_fmu(tmp_path / "types.fmu", text, {"win64/types.dll": b""})

    with pytest.raises(
        ConfigError, match=f"no binary for this platform, got win64, expected {FOLDERS[version]}"
    ):
        run(tmp_path, {"a": {"source": "./types.fmu"}})
