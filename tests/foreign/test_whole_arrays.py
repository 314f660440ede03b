"""Arrays of FMI 3.0 that are set whole or in part."""

import numpy as np
import pytest

from master.errors import ConfigError
from tests.foreign.build import describe_3
from tests.foreign.foreign import COMPILED, run, wires

pytestmark = COMPILED


def doubled(result, name="a"):
    return [result[f"{name}.b[{i},{j}]"][-1] for i in (1, 2) for j in (1, 2, 3)]


@pytest.mark.parametrize(
    ("value", "expected"),
    [
        ([1, 0, 2, 0, 3, 0], [2.0, 0.0, 4.0, 0.0, 6.0, 0.0]),
        ([[1, 0, 2], [0, 3, 0.5]], [2.0, 0.0, 4.0, 0.0, 6.0, 1.0]),
        (2.5, 6 * [5.0]),
    ],
)
def test_a_whole_array_is_set_from_a_list_or_one_number(fmu, tmp_path, value, expected):
    fmu("3.0")
    result = run(tmp_path, {"a": {"source": "./types3.fmu", "start": {"a": value}}}).result

    assert doubled(result) == expected


def test_a_value_for_an_element_counts_more_than_one_for_all(fmu, tmp_path):
    fmu("3.0")
    start = {"a[2,1]": 7.0, "a": 1.0}
    result = run(tmp_path, {"a": {"source": "./types3.fmu", "start": start}}).result

    assert doubled(result) == [2.0, 2.0, 2.0, 14.0, 2.0, 2.0]


@pytest.mark.parametrize(
    ("value", "got"),
    [
        ([1, 2, 3], "a list of 3"),
        ([[1, 2], [3, 4], [5, 6]], "a list of 3 x 2"),
        ([[1, 2, 3], [4, 5]], "a list whose parts differ"),
        ([], "a list of 0"),
    ],
)
def test_a_list_of_another_shape_is_refused(fmu, tmp_path, value, got):
    fmu("3.0")
    with pytest.raises(
        ConfigError, match=f"start.a: value not allowed, got {got}, expected 2 x 3 values or one"
    ):
        run(tmp_path, {"a": {"source": "./types3.fmu", "start": {"a": value}}})


def test_a_value_that_an_element_does_not_take_names_it(fmu, tmp_path):
    fmu("3.0")
    with pytest.raises(
        ConfigError, match=r"start\.ia: value not allowed, got 1\.5 for ia\[2\], expected an integer"
    ):
        run(tmp_path, {"a": {"source": "./types3.fmu", "start": {"ia": [1, 1.5]}}})


@pytest.mark.parametrize("start", ['start="9"', 'start="9 9"', ""])
def test_a_short_start_list_leaves_the_other_elements_as_the_fmu_has_them(fmu, tmp_path, start):
    fmu("3.0", describe_3().replace('start="1 2 3 4 5 6"', start))
    result = run(tmp_path, {"a": {"source": "./types3.fmu", "start": {"a[1,2]": 20.0}}}).result

    assert doubled(result) == [2.0, 40.0, 6.0, 8.0, 10.0, 12.0]


def test_a_wire_to_an_element_leaves_the_others_as_the_fmu_has_them(fmu, tmp_path):
    fmu("3.0", describe_3().replace('start="1 2 3 4 5 6"', 'start="9"'))
    fmus = {name: {"source": "./types3.fmu"} for name in "ab"}
    result = run(tmp_path, fmus, wires(("a.b[1,2]", "b.a[2,3]"))).result

    assert doubled(result, "b") == [2.0, 4.0, 6.0, 8.0, 10.0, 8.0]


def test_a_start_list_that_is_too_long_is_refused(fmu, tmp_path):
    fmu("3.0", describe_3().replace('start="1 2 3 4 5 6"', 'start="1 2 3 4 5 6 7"'))
    with pytest.raises(ConfigError, match="ModelVariables/Float64 'a': start: got 7 values, expected 6"):
        run(tmp_path, {"a": {"source": "./types3.fmu"}})


def test_an_event_sets_a_whole_array_and_takes_it_back(fmu, tmp_path):
    fmu("3.0")
    events = [
        {"at": 0.1, "for": 0.2, "set": {"a.a": [[1, 2, 3], [4, 5, 6.5]], "a.ia": 7}},
        {"at": 0.2, "for": 0.1, "set": {"a.a[2,1]": -4}},
    ]
    fmus = {"a": {"source": "./types3.fmu", "start": {"a": [10, 20, 30, 40, 50, 60], "ia": [1, 2]}}}
    result = run(tmp_path, fmus, events=events).result
    start = [10.0, 20.0, 30.0, 40.0, 50.0, 60.0]
    given = [1.0, 2.0, 3.0, 4.0, 5.0, 6.5]
    sent = [start, start, given, [*given[:3], -4.0, *given[4:]], start, start]

    of_b = np.array([result[f"a.b[{i},{j}]"] for i in (1, 2) for j in (1, 2, 3)]).T
    assert np.array_equal(of_b, 2.0 * np.array(sent))
    assert result["a.ib[2]"].tolist() == [4.0, 4.0, 14.0, 14.0, 4.0, 4.0]


def test_a_fault_on_a_whole_array_acts_on_each_of_its_connected_elements(fmu, tmp_path):
    fmu("3.0")
    fmus = {name: {"source": "./types3.fmu"} for name in "ab"}
    fmus["a"]["start"] = {"a": [1, 2, 3, 4, 5, 6]}
    events = [{"at": 0.2, "for": 0.1, "offset": {"b.a": 100.0}}]
    result = run(tmp_path, fmus, wires(("a.b", "b.a")), events=events).result

    assert result["b.b[1,1]"].tolist()[1:] == [4.0, 4.0, 204.0, 4.0, 4.0]
    assert result["b.b[2,3]"].tolist()[1:] == [24.0, 24.0, 224.0, 24.0, 24.0]


def test_a_list_of_another_shape_in_an_event_is_refused(fmu, tmp_path):
    fmu("3.0")
    events = [{"at": 0.1, "set": {"a.a": [1, 2, 3]}}, {"at": 0.1, "set": {"a.Float64_in": [1]}}]
    with pytest.raises(ConfigError) as caught:
        run(tmp_path, {"a": {"source": "./types3.fmu"}}, events=events)

    shape, scalar = caught.value.problems
    assert shape.endswith("a.a: value not allowed, got a list of 3, expected 2 x 3 values or one for all")
    assert scalar.endswith("value not allowed, got a list, expected one value for Float64_in")
