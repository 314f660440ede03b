"""Variables may have any name: in wires, values, events, conditions, limits and rows."""

from xml.sax.saxutils import quoteattr

import pytest

from master.errors import ConfigError
from tests.foreign.build import describe_2
from tests.foreign.foreign import COMPILED, run, wires

pytestmark = COMPILED

NAMES = [
    "u v",
    "a<b",
    "x > 1",
    "p=q",
    'say "u"',
    "\u00fc[1]",
    "der(x)",
    "a.b.c",
    "$a_{b$",
    "a,b;c",
    "'q'",
    "%s{0}",
]


@pytest.mark.parametrize("name", NAMES)
def test_a_variable_of_any_name_is_used_everywhere(fmu, tmp_path, name):
    text = describe_2()
    for end in ("in", "out"):
        text = text.replace(f'"Real_{end}"', quoteattr(f"{name} {end}"))
    fmu("2.0", text)
    fmus = {"a": {"source": "./types2.fmu", "start": {f"{name} in": 1.0}}, "b": {"source": "./types2.fmu"}}
    events = [
        {"at": 0.2, "set": {f"a.{name} in": 4.0}},
        {"when": f"a.{name} out > 3", "offset": {f"b.{name} in": 0.5}},
    ]
    limits = {f"b.{name} out": 10.0}
    wired = wires((f"a.{name} out", f"b.{name} in"))
    outcome = run(tmp_path, fmus, wired, events=events, limits=limits)

    assert outcome.status == "completed"
    assert outcome.result[f"a.{name} out"].tolist() == [1.0, 1.0, 1.0, 4.0, 4.0, 4.0]
    assert outcome.result[f"b.{name} out"][3:].tolist() == [4.0, 4.5, 4.5]


@pytest.mark.parametrize("name", NAMES)
def test_a_fault_names_a_variable_as_it_is(fmu, tmp_path, name):
    fmu("2.0", describe_2().replace('"Real_in"', quoteattr(name)))
    with pytest.raises(ConfigError) as caught:
        run(tmp_path, {"a": {"source": "./types2.fmu", "start": {name: "wide"}}})

    assert f"fmus.a.start.{name}: value not allowed, got 'wide', expected a number" in str(caught.value)
