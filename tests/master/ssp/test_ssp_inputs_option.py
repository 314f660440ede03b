"""`--inputs`: a recording that a command gets drives the inputs of an archive, or is refused by column."""

import numpy as np
import pytest
from click.testing import CliRunner

from master.cli import main
from master.errors import ConfigError
from master.experiment.prepare import Request, prepare
from master.recording.names import results_folder
from tests.master.ssp.boxes import run
from tests.master.ssp.ssp_archives import (
    ENUMERATIONS,
    UNITS,
    component,
    connector,
    connectors,
    link,
    links,
    structure,
    system,
    write,
)

TIMES = '<ssd:DefaultExperiment startTime="0" stopTime="0.004"/>'
PORTS = (connector("u", "input", "Real", "mm"), connector("n", "input", "Integer"))
WIRES = (link(".u", "a.u"), link(".n", "a.i"))


@pytest.fixture
def archive(tmp_path):
    content = system(component("a"), component("b"), before=connectors(*PORTS), after=links(*WIRES))
    return write(tmp_path, structure(content, more=ENUMERATIONS + UNITS + TIMES), {})


@pytest.fixture
def given(tmp_path):
    def make(header, *rows):
        path = tmp_path / "stimulus.csv"
        path.write_text("\n".join([header, *rows]) + "\n")
        return path

    return make


def faults(archive, path):
    with pytest.raises(ConfigError) as caught:
        prepare(archive, Request(inputs=path))
    return list(caught.value.problems)


@pytest.mark.parametrize(
    ("header", "factor"),
    [
        ("t,u,n", 1.0),
        ("Time,root.u,root.n", 1.0),
        ("t,u [m],n", 1e3),
        ("t,root.u [mm],n", 1.0),
        ("n,time [ms],u", 1.0),
    ],
)
def test_columns_drive_the_inputs_that_they_are_called_as_in_their_units(archive, given, header, factor):
    """A step uses the values at its start: mm on a line, integers held; the FMU counts in m."""
    names = header.split(",")
    cells = {"u": ("0", "8"), "n": ("3", "5"), "t": ("0", "4" if "[ms]" in header else "0.004")}
    kinds = [next(k for k in "utn" if k in name.lower().replace("root", "").split()[0]) for name in names]
    rows = (",".join(cells[kind][i] for kind in kinds) for i in (0, 1))
    result = run(archive, inputs=given(header, *rows)).result

    assert result["a.y"] == pytest.approx(np.array([0, 0, 2, 4, 6]) * 1e-3 * factor, abs=1e-15)
    assert result["a.i_y"].tolist() == [3, 3, 3, 3, 3]


def test_an_input_of_an_fmu_that_is_not_connected_is_driven_by_its_own_name(archive, given):
    path = given("t,b.bare", "0,1", "0.002,5", "0.004,5")

    assert run(archive, inputs=path).result["b.bare_y"].tolist() == [1, 1, 3, 5, 5]


@pytest.mark.parametrize(
    ("header", "row", "said"),
    [
        ("t,u,w", "0,1,1", ["--inputs: column 'w': no such input, got 'w', expected"]),
        ("t,u,w,v", "0,1,1,1", ["column 'w': no such input", "column 'v': no such input"]),
        ("t,u,root.u", "0,1,1", ["--inputs: column 'root.u': drives 'root.u' as 'u' does, expected one column"]),
        ("t,u [N]", "0,1", ["--inputs: column 'u [N]': unit does not fit, got 'N', expected mm"]),
        ("t,u [furlong]", "0,1", ["--inputs: column 'u [furlong]': "]),
        ("t [m],u", "0,1", ["--inputs: not a time, got 'm'"]),
        ("t,u,a.u", "0,1,1\n0.004,1,1", ["--inputs: column 'a.u': has two sources, got 'a.u' again"]),
        ("t,a.y", "0,1", ["--inputs: column 'a.y': no such input"]),
        ("t,u", "0,word", ["row 2, column 'u': got 'word', expected a number"]),
        ("t,u", "1,1", ["begins at 1 s, expected a sample at or before the start"]),
        ("t", "0", ["--inputs: no columns but that of the time"]),
    ],
)  # fmt: skip
def test_what_is_wrong_with_the_file_is_said_by_column(archive, given, header, row, said):
    found = "\n".join(faults(archive, given(header, row)))

    for text in said:
        assert text in found


def test_a_file_that_is_no_table_is_refused(archive, tmp_path):
    (tmp_path / "x.xyz").write_text("t,u\n0,1\n")

    assert faults(archive, tmp_path / "nix.csv") == [f"--inputs: {tmp_path}/nix.csv: no such file"]
    assert "kind of file, got '.xyz'" in faults(archive, tmp_path / "x.xyz")[0]


def test_the_ledger_and_the_notes_say_which_value_a_step_uses(archive, given):
    experiment = prepare(archive, Request(inputs=given("t,u", "0,1", "0.004,1")))
    entry = next(e for e in experiment.ledger.entries if e.target == "a.u")

    assert (entry.least, entry.most) == (1, 1)
    assert entry.source.endswith("stimulus.csv: u")
    assert any(note.startswith("--inputs: between two samples a Real") for note in experiment.notes)


@pytest.mark.parametrize("command", ["run", "check", "explain"])
def test_each_command_refuses_a_column_that_is_no_input(archive, given, command):
    done = CliRunner().invoke(main, [command, str(archive), "--inputs", str(given("t,w", "0,1"))])

    assert done.exit_code == 2
    assert "--inputs: column 'w': no such input, got 'w', expected" in done.stderr


def test_results_of_a_driven_run_go_to_a_folder_of_their_own():
    driven = results_folder("s", None, ["inputs=stimulus.csv"])

    assert driven != results_folder("s", None, [])
    assert driven.name == "default,inputs=stimulus.csv"
