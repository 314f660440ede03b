import pytest

from master.errors import ConfigError
from master.system.config import load_config, with_times

HEAD = "name: test\nstop_time: 1.0\nfmus:\n  a: {source: clock.fmu}\n"


@pytest.fixture
def load(tmp_path):
    path = tmp_path / "system.yaml"

    def read(text):
        path.write_text(text, encoding="utf-8")
        return load_config(path)

    return read


@pytest.fixture
def faults(load, tmp_path):
    def found(text):
        with pytest.raises(ConfigError) as caught:
            load(text)
        return [p.replace(f"{tmp_path}/", "") for p in caught.value.problems]

    return found


def test_what_the_file_leaves_out_has_its_default(load):
    config = load(HEAD).config

    assert (config.step_size, config.start_time, config.n_ticks) == (1e-3, 0.0, 1000)
    assert (config.fmus["a"].every, config.coupling.order, config.compare) == (1, None, None)


def test_a_connection_is_read_from_from_and_to(load):
    [wire] = load(HEAD + "connections: [{from: a.t, to: b.u, delay: 3}]\n").config.connections

    assert (wire.source, wire.target, wire.delay) == ("a.t", "b.u", 3)


def test_an_order_may_hold_inner_lists(load):
    config = load(HEAD + "coupling: {order: [a, [b, c]]}\n").config

    assert config.coupling.order == ["a", ["b", "c"]]


@pytest.mark.parametrize(
    ("entry", "fault"),
    [
        (
            "{iterate: [a], tolerance: 0}",
            "coupling.order[0].tolerance: too small, got 0, expected more than 0",
        ),
        (
            "{step: [a]}",
            "coupling.order[0]: not an entry of the order, expected a name, a list of names or a mapping "
            "with iterate or waveform, got a mapping",
        ),
        ("[a, [b]]", "coupling.order[0][1]: not a text, got ['b'], expected a text"),
        ("{iterate: a}", "coupling.order[0].iterate: not a list, got 'a', expected a list"),
    ],
)
def test_a_fault_of_an_order_is_said_once_and_where_it_is(faults, entry, fault):
    assert faults(HEAD + f"coupling: {{order: [{entry}]}}\n") == [f"system.yaml:5: {fault}"]


@pytest.mark.parametrize("name", ["a.b", "'a b'", "''", "a>b"])
def test_a_name_that_signals_cannot_be_made_of_is_refused(faults, name):
    [fault] = faults(HEAD.replace("  a:", f"  {name}:"))

    assert "not a name without spaces, '.', '<' and '>'" in fault
    assert fault.startswith("system.yaml:4: fmus.")


@pytest.mark.parametrize(
    ("values", "fault"),
    [
        ("{'a.b': {p: 1}}", "variants.v.a.b: not a name without spaces, '.', '<' and '>', got 'a.b'"),
        ("{a: {'': 1}}", "variants.v.a.: not a name of a variable, got '', expected one character at least"),
    ],
)
def test_a_variant_names_what_signals_can_be_made_of(faults, values, fault):
    assert faults(HEAD + f"variants: {{v: {values}}}\n") == [f"system.yaml:5: {fault}"]


def test_missing_keys_are_named(faults):
    assert faults("name: test\n") == [
        "system.yaml:1: stop_time: missing, expected a value, for example `stop_time: 10.0`",
        "system.yaml:1: fmus: missing, expected a value, "
        "for example `fmus: {spacecraft: {source: spacecraft}}`",
    ]


def test_an_unknown_key_is_answered_with_the_nearest_one(faults):
    [fault] = faults(HEAD + "conections: []\n")

    assert fault.startswith(
        "system.yaml:5: conections: unknown key, got [], expected 'connections' (of name, "
    )


def test_an_unknown_key_of_an_fmu_is_answered_with_the_keys_of_an_fmu(faults):
    [fault] = faults("name: test\nstop_time: 1.0\nfmus:\n  a:\n    source: x.fmu\n    evry: 2\n")

    assert fault.startswith("system.yaml:6: fmus.a.evry: unknown key, got 2, expected 'every' (of source, ")


@pytest.mark.parametrize(
    ("line", "fault"),
    [
        ("step_size: fast", "step_size: not a number, got 'fast', expected a number"),
        ("step_size: 0", "step_size: too small, got 0, expected more than 0"),
        ("step_size: .inf", "step_size: not a finite number, got .inf"),
        ("start_time: .nan", "start_time: not a finite number, got .nan"),
        ("connections: [{from: a, to: b.u}]", "connections[0].from: not an 'instance.variable', got 'a'"),
        ("limits: {a.t: -1}", "limits.a.t: too small, got -1, expected more than 0"),
        ("compare: {signal: a.t, offset: 0}", "compare.offset: too small, got 0, expected more than 0"),
        (
            "dpdc: {design: auto, amplitude: flat}",
            "dpdc.amplitude: not one of the choices, got 'flat', expected 'paper' or 'plant'",
        ),
        ("dpdc: {amplitude: plant}", "dpdc.design: missing, expected a value, for example `design: auto`"),
        (
            "dpdc: {design: auto, amplitud: plant}",
            "dpdc.amplitud: unknown key, got 'plant', "
            "expected 'amplitude' (of design, fmu, amplitude, ranges)",
        ),
    ],
)
def test_a_value_of_the_wrong_kind_is_refused(faults, line, fault):
    [found] = faults(HEAD + line + "\n")

    assert found.startswith(f"system.yaml:5: {fault}")


def test_an_fmu_steps_at_least_every_tick(faults):
    assert faults("name: a\nstop_time: 1\nfmus: {a: {source: x.fmu, every: 0}}\n") == [
        "system.yaml:3: fmus.a.every: too small, got 0, expected at least 1"
    ]


def test_a_system_has_an_fmu(faults):
    [fault] = faults("name: a\nstop_time: 1\nfmus: {}\n")

    assert fault.startswith("system.yaml:3: fmus: too few entries, got an empty mapping, expected at least 1")


def test_all_faults_come_at_once(faults):
    text = "name: [3]\nstep_size: no\nstop_time: 1.0\nfmus:\n  a: {every: 2}\nvariant: {}\n"

    places = [f.split(": ")[:2] for f in faults(text)]

    assert places == [
        ["system.yaml:1", "name"],
        ["system.yaml:2", "step_size"],
        ["system.yaml:5", "fmus.a.source"],
        ["system.yaml:6", "variant"],
    ]


def test_a_stop_time_between_two_steps_is_refused(faults):
    assert faults(HEAD.replace("1.0", "0.0014")) == [
        "system.yaml:2: stop_time: 1.4 steps after start_time, got 0.0014, expected a whole number"
    ]


@pytest.mark.parametrize("step_size", ["1e-300", "5e-324"])
def test_more_steps_than_a_double_counts_are_refused(faults, step_size):
    [fault] = faults(HEAD + f"step_size: {step_size}\n")

    assert fault.startswith("system.yaml:2: stop_time: ")
    assert fault.endswith(" steps, got 1.0, expected at most 9.01e+15")


def test_a_stop_time_before_the_start_is_refused(faults):
    assert faults(HEAD + "start_time: 2.0\n") == [
        "system.yaml:2: stop_time: not after start_time, got 1.0, expected more than 2"
    ]


def test_a_stop_time_that_binary_numbers_cannot_hold_is_taken(load):
    assert load(HEAD.replace("1.0", "0.7") + "step_size: 0.1\n").config.n_ticks == 7


def test_another_stop_time_must_fit_too(load):
    config = load(HEAD).config

    assert with_times(config, None, 0.25).n_ticks == 250
    with pytest.raises(ConfigError) as caught:
        with_times(config, None, 0.0005)
    assert caught.value.problems == [
        "--stop-time: 0.5 steps after start_time, got 0.0005, expected a whole number"
    ]


@pytest.mark.parametrize(("text", "kind"), [("- a\n", "['a']"), ("", "nothing"), ("word\n", "'word'")])
def test_a_file_that_holds_no_mapping_is_refused(faults, text, kind):
    assert faults(text) == [
        f"system.yaml:1: file: not a system, got {kind}, expected a mapping with name, stop_time, fmus, ..."
    ]


def test_a_configuration_cannot_be_changed(load):
    with pytest.raises(ValueError, match="frozen"):
        load(HEAD).config.name = "other"
