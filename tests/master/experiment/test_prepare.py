import pytest

from master.experiment.prepare import Request, prepare

TEXT = """\
name: test
step_size: 0.5
stop_time: 4.0
fmus:
  clock: {source: clock.fmu}
  mass: {source: integrator.fmu, parameters: {size: 1.0}}
connections:
  - {from: clock.t, to: mass.u}
variants:
  big: {mass: {size: 5, label: big}}
compare: {signal: mass.x, offset: 0.01}
limits:
  clock.t: 3.0
"""


def start_of(bay, **request):
    return prepare(bay.write(TEXT), Request(**request)).system.instances["mass"].start


def test_a_system_is_made_of_its_file(bay):
    experiment = prepare(bay.write(TEXT))

    assert list(experiment.system.instances) == ["clock", "mass"]
    assert experiment.schedule.members == (("clock",), ("mass",))
    assert (experiment.grid.t0, experiment.grid.step_size, experiment.grid.n_ticks) == (0.0, 0.5, 8)
    assert [e.least for e in experiment.ledger.entries] == [0]


def test_a_compared_motion_is_limited_to_100_offsets_beside_the_own_limits(bay):
    assert prepare(bay.write(TEXT)).limits == {"mass.x": 1.0, "clock.t": 3.0}


def test_a_variant_stands_above_the_file_and_an_assignment_above_the_variant(bay):
    assert start_of(bay) == {"size": 1.0}
    assert start_of(bay, variant="big") == {"size": 5.0, "label": "big"}
    assert start_of(bay, variant="big", assignments=("mass.size=7",))["size"] == 7.0


@pytest.mark.parametrize(
    ("assignment", "key", "value"),
    [
        ("choice=second", "choice", 2),
        ("on=true", "on", 1.0),
        ("size=1e-3", "size", 0.001),
        ("count=3", "count", 3.0),
    ],
)
def test_an_assignment_takes_names_numbers_and_truths(bay, assignment, key, value):
    assert start_of(bay, assignments=(f"mass.{assignment}",))[key] == value


EVENT = "events:\n  - {at: %s, freeze: mass.u}\n"


@pytest.mark.parametrize(("at", "stop_time"), [(3.5, None), (3.5, 1.5), (4.5, 6.0)])
def test_an_event_lies_within_the_file_s_run_or_a_longer_one(bay, at, stop_time):
    assert len(prepare(bay.write(TEXT + EVENT % at), Request(stop_time=stop_time)).scenario.events) == 1


@pytest.mark.parametrize("stop_time", [None, 1.5])
def test_an_event_behind_the_end_of_the_run_is_refused(bay, stop_time):
    assert bay.faults(TEXT + EVENT % 4.0, stop_time=stop_time) == [
        "system.yaml:15: events[0]: not within the run, got at 4 s, expected from 0 s to before 4 s"
    ]


def test_another_stop_time_is_taken(bay):
    assert prepare(bay.write(TEXT), Request(stop_time=1.5)).grid.n_ticks == 3


def test_an_unknown_variant_is_answered_with_the_variants(bay):
    assert bay.faults(TEXT, variant="bigg") == [
        "--variant: no such variant, got 'bigg', expected 'big' (of big)"
    ]


@pytest.mark.parametrize("chosen", [None, "wrong"])
def test_a_wrong_value_in_a_variant_is_shown_once_chosen_or_not(bay, chosen):
    text = TEXT.replace("compare:", "  wrong: {mass: {size: 50}, moon: {size: 1}}\ncompare:")

    assert bay.faults(text, variant=chosen) == [
        "system.yaml:11: variants.wrong.mass.size: value not allowed, got 50 m, expected at most 10",
        "system.yaml:11: variants.wrong.moon.size: no such FMU, got 'moon', expected one of clock, mass",
    ]


@pytest.mark.parametrize("text", ["mass.size", "size=3", "mass.size=", "mass.size=["])
def test_what_is_not_an_assignment_is_refused(bay, text):
    assert bay.faults(TEXT, assignments=(text,)) == [
        f"--set: not an assignment, got {text!r}, expected fmu.parameter=value"
    ]


@pytest.mark.parametrize(
    ("text", "fault"),
    [
        ("mass.size=[1, 2]", "--set mass.size: value not allowed, got a list, expected one value for size"),
        ("moon.size=3", "--set moon.size: no such FMU, got 'moon', expected one of clock, mass"),
        (
            "mass.siz=3",
            "--set mass.siz: no such variable in mass (integrator), got 'siz', "
            "expected 'size' (of u, x, size, choice, on, count, label)",
        ),
        ("mass.size=.nan", "--set mass.size: value not allowed, got .nan m, expected a finite number"),
        ("mass.size=wide", "--set mass.size: value not allowed, got 'wide' m, expected a number"),
        (
            "mass.u=3",
            "--set mass.u: has two sources, got a start value and a connection to mass.u, expected one",
        ),
        (
            "mass.choice=third",
            "--set mass.choice: value not allowed, got 'third', expected one of first, second",
        ),
    ],
)
def test_an_assignment_that_does_not_fit_is_refused(bay, text, fault):
    assert bay.faults(TEXT, assignments=(text,)) == [fault]


def test_missing_files_and_files_that_are_no_fmus_come_with_their_lines(bay):
    (bay.folder / "text.fmu").write_text("no archive", encoding="utf-8")
    (bay.folder / "word.fmu").write_text("no archive", encoding="utf-8")
    text = "name: a\nstop_time: 1\nfmus:\n  a: {source: %s}\n  b: {source: %s}\n"

    assert bay.faults(text % ("absent.fmu", "gone.fmu")) == [
        "system.yaml:4: fmus.a.source: no such file, got 'absent.fmu', expected an FMU at absent.fmu",
        "system.yaml:5: fmus.b.source: no such file, got 'gone.fmu', expected an FMU at gone.fmu",
    ]
    assert bay.faults(text % ("text.fmu", "word.fmu")) == [
        f"system.yaml:{line}: fmus.{name}.source: {file}.fmu: not an FMU, "
        "expected a zip archive with modelDescription.xml"
        for line, name, file in ((4, "a", "text"), (5, "b", "word"))
    ]


def test_an_unknown_model_is_answered_with_the_nearest_one(bay):
    [fault] = bay.faults("name: a\nstop_time: 1\nfmus:\n  a: {source: spacecraff}\n")

    assert fault.startswith("system.yaml:4: fmus.a.source: no such model, got 'spacecraff', ")
    assert "expected 'spacecraft' (of " in fault
    assert fault.endswith("), or a path to an FMU")


def test_a_loop_without_an_order_is_refused_where_the_order_would_stand(bay):
    text = TEXT.replace("from: clock.t", "from: mass.x")

    assert bay.faults(text) == [
        "system.yaml:1: coupling.order: missing although the system has a loop, got mass -> mass, "
        "expected the order of stepping"
    ]


def test_a_wrong_order_is_shown_with_its_line(bay):
    assert bay.faults(TEXT + "coupling:\n  order: [mass, mass]\n") == [
        "system.yaml:15: coupling.order: stands twice, got 'mass', expected each FMU once",
        "system.yaml:15: coupling.order: incomplete, got no clock, expected every FMU once",
    ]


def test_faults_of_all_stages_come_at_once(bay):
    text = TEXT.replace("step_size: 0.5", "step_sice: 0.5").replace("  clock.t: 3.0\n", "  clock.x: 3.0\n")
    text = text.replace("{source: clock.fmu}", "{source: clock.fmu, every: 0}")
    text += "coupling: {order: [clock, mass, moon]}\nevents: [{at: 1, freeze: mass.x}]\n"
    faults = bay.faults(text + "extra: 3\n", assignments=("mass.siz=3", "x"), variant="bigg")

    assert [fault.split(", ")[0] for fault in faults] == [
        "system.yaml:5: fmus.clock.every: too small",
        "system.yaml:2: step_sice: unknown key",
        "system.yaml:16: extra: unknown key",
        "--variant: no such variant",
        "--set: not an assignment",
        "--set mass.siz: no such variable in mass (integrator)",
        "system.yaml:13: limits.clock.x: no such output of clock (clock)",
        "system.yaml:14: coupling.order: no such FMU",
        "system.yaml:15: events[0]: mass.x: not a connected input",
    ]


def test_nothing_is_said_of_an_fmu_that_cannot_be_read(bay):
    text = TEXT.replace("integrator.fmu", "nothing.fmu") + "coupling: {order: [clock, mass]}\n"
    text += (
        "events: [{at: 1, freeze: mass.u}, {at: 1, set: {mass.size: 3}}, {when: mass.x > 1, drop: mass.u}]\n"
    )

    assert bay.faults(text, assignments=("mass.nothing=3",)) == [
        "system.yaml:6: fmus.mass.source: no such file, got 'nothing.fmu', expected an FMU at nothing.fmu"
    ]


@pytest.mark.parametrize("entry", ["[mass]", "{iterate: [mass]}"])
def test_an_entry_of_the_order_whose_fmus_cannot_be_read_adds_no_fault(bay, entry):
    text = TEXT.replace("integrator.fmu", "nothing.fmu") + f"coupling: {{order: [clock, {entry}]}}\n"

    assert bay.faults(text) == [
        "system.yaml:6: fmus.mass.source: no such file, got 'nothing.fmu', expected an FMU at nothing.fmu"
    ]


def test_a_signal_is_set_once(bay):
    assert bay.faults(TEXT, assignments=("mass.size=3", "mass.size=4")) == [
        "--set mass.size: is given twice, expected one value"
    ]


@pytest.mark.parametrize("text", ["010", "1.10", "true", "1e3", "12:30", "2024-01-05", "yes", "null"])
def test_a_string_is_the_text_as_written(bay, text):
    written = TEXT.replace("size: 1.0", f"label: {text}")

    assert prepare(bay.write(written)).system.instances["mass"].start == {"label": text}
    assert start_of(bay, assignments=(f"mass.label={text}",))["label"] == text


def test_a_number_with_a_leading_zero_is_decimal(bay):
    assert start_of(bay, assignments=("mass.size=010",))["size"] == 10.0


@pytest.mark.parametrize("value", ["true", "yes", "1:30", "1_0", "0b1"])
def test_a_word_is_no_number(bay, value):
    [fault] = bay.faults(TEXT.replace("size: 1.0", f"size: {value}"))

    assert fault.startswith("system.yaml:6: fmus.mass.parameters.size: value not allowed, got ")
    assert fault.endswith(", expected a number")


def test_a_run_may_end_at_zero(bay):
    grid = prepare(bay.write(TEXT.replace("stop_time: 4.0", "start_time: -5\nstop_time: 0"))).grid

    assert (grid.t0, grid.n_ticks) == (-5.0, 10)


@pytest.mark.parametrize("step_size", ["1e300", "1e-300", "1e-20"])
def test_a_step_that_no_run_bears_is_refused(bay, step_size):
    [fault] = bay.faults(TEXT.replace("step_size: 0.5", f"start_time: 3\nstep_size: {step_size}"))

    assert fault.startswith("system.yaml:4: stop_time: ")


def test_an_fmu_whose_step_is_longer_than_the_run_is_noted(bay):
    text = TEXT.replace("{source: clock.fmu}", "{source: clock.fmu, every: 9}")

    assert prepare(bay.write(text.replace("9}", "8}"))).notes == []
    note = "clock is never stepped, got a step every 9 ticks in a run of 8"
    assert prepare(bay.write(text)).notes == [note]


def test_an_event_within_a_waveform_group_is_refused_before_a_run(bay):
    order = "coupling: {order: [{waveform: [clock, mass], window: 3}]}\n"
    [fault] = bay.faults(TEXT + order + "events: [{at: 2.0, freeze: mass.u}]\n")

    assert "events" in fault
    assert "mass.u is closed over a window of 3 ticks by a waveform group, got a fault on it" in fault
