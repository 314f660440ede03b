from __future__ import annotations

import io
from types import SimpleNamespace

import numpy as np
import pytest

from fmu_sources.effects.catalogue import effect, listed
from master.diagnosis.answer.report import tables
from master.diagnosis.answer.report.charts import curve, residual_charts
from master.diagnosis.answer.report.compared import worst_stretch
from master.diagnosis.answer.report.drawing import broken, thinned
from master.diagnosis.answer.report.learned_law import at_once, replayed
from master.diagnosis.answer.report.page import page
from master.diagnosis.answer.report.panels import Panel
from master.diagnosis.answer.report.residual import residual, where
from master.diagnosis.answer.report.spoken import equation_of, first_sentence, laws
from master.pages.chart import REFERENCE, Chart, Curve
from tests.master.diagnosis.answer.made_up_report import CHANNEL, UNITS, made_up_report


def test_a_thinned_line_keeps_its_peaks():
    t = np.arange(100_000.0)
    values = np.sin(t)
    values[[777, 50_001]] = 9.0, -8.0

    _, kept = thinned(t, values)

    assert len(kept) < 5_000
    assert (kept.max(), kept.min()) == (9.0, -8.0)


def test_a_line_does_not_bridge_rows_that_are_missing():
    t, values = broken(
        np.array([0.0, 0.1, 0.2, 0.7, 0.8, 0.3]), np.arange(6.0)
    )  # the last: another recording

    assert np.flatnonzero(np.isnan(t)).tolist() == [3, 6]
    assert np.flatnonzero(np.isnan(values)).tolist() == [3, 6]


def test_the_worst_stretch_is_where_the_power_is():
    residual = np.full(10_000, 0.1)
    residual[6_000:6_300] = -5.0

    rows = worst_stretch(residual)

    assert rows.start <= 6_000
    assert rows.stop >= 6_300
    assert rows.stop - rows.start == 600


def motion(velocity, t):
    return {"time": t, "value": np.ones_like(t), "position": velocity * t, "velocity": velocity + 0.0 * t}


def test_a_law_is_drawn_as_what_it_adds():
    t = np.arange(500) * 1e-3
    p = SimpleNamespace(level=3.0, smoothing=0.01)

    added = at_once(effect("coulomb"), p, motion(0.02, t))
    assert added == pytest.approx(3.0 * np.tanh(2.0) + 0.0 * t)
    assert replayed(effect("coulomb"), p, motion(0.02, t)) == pytest.approx(added, abs=1e-12)


def test_a_law_with_memory_is_drawn_along_each_recording():
    t = np.arange(500) * 1e-3
    p = SimpleNamespace(stiffness=1e3, forward=2.0, backward=2.0)
    twice = {name: np.tile(values, 2) for name, values in motion(0.01, t).items()}

    added = replayed(effect("presliding"), p, twice)

    stuck = t < 0.15  # slides at F/k = 2 mm, after 0.2 s; its corner is rounded
    assert added[:500][stuck] == pytest.approx(10.0 * t[stuck], rel=1e-3, abs=1e-9)
    assert added[499] == pytest.approx(2.0, rel=0.01)
    assert added[500:] == pytest.approx(added[:500])


def test_the_page_gives_verdict_errors_and_parameters_with_units(tmp_path):
    (tmp_path / "axis_sealed.png").write_bytes(b"picture")
    text = page(made_up_report(), [Panel("axis", tmp_path / "axis_sealed.png", "Below it.")], UNITS)

    assert "a &lt;case&gt;" in text
    assert text.index("The model lacks Coulomb friction") < text.index("Traced: axis.friction: coulomb.")
    assert text.index("Traced: axis.friction: coulomb.") < text.index("<table>")
    assert "F = value + F_c tanh(v / v_0)</pre>" in text
    assert "RMSE 2 \u2192 <b>1 N</b> (20 \u2192 10 %)" in text
    assert "<td>N</td>" in text
    assert "20.5 ± 0.12" in text
    assert "Status: <b>traced</b>; it takes 75 % (70 to 80 %)" in text
    assert "0.9 (rest)" in text
    assert "70 (60 to 80)" in text
    assert "coulomb or dahl. <b>Record slowly.</b>" in text
    assert 'src="data:image/png;base64,cGljdHVyZQ=="' in text


def test_the_first_sentence_has_law_values_errors_and_noise_floors():
    """By hand: errors of 1 and 2 N over a floor of 0.9 N are 1.11 and 2.22 of it."""
    assert first_sentence(made_up_report(), UNITS) == (
        "The model lacks Coulomb friction (level 20.5 ± 0.12 N) in axis.friction. On rows that nothing was "
        "fitted to, axis.force is off by 1 N rms with it, and by 2 N without: 1.11 and 2.22 times the noise "
        "floor of 0.9 N."
    )


def test_without_an_effect_the_first_sentence_says_what_is_left():
    report = made_up_report() | {"effects": []}

    assert first_sentence(report, UNITS).startswith("No law was added to the model. On rows that nothing was")
    assert "axis.force is off by 1 N rms: 1.11 times the noise floor of 0.9 N." in first_sentence(
        report, UNITS
    )


def test_a_law_that_is_only_the_nearest_is_not_said_to_be_missing():
    report = made_up_report()
    report["effects"][0]["status"] = "nearest name"

    assert first_sentence(report, UNITS).startswith(
        "No law is sure; the nearest is Coulomb friction (level 20.5"
    )
    assert "in axis.friction (nearest name). On rows" in first_sentence(report, UNITS)


def test_a_parameter_that_could_be_nearly_anything_has_no_number_in_sentence_and_table():
    report = made_up_report()
    why = "its 95 % interval of +- 40 around 20.5 holds nearly all that it could be"
    report["effects"][0]["parameters"]["level"] = None
    report["parameters"]["axis.friction_coulomb_level"] |= {"with_effect": None, "no_number": why}

    assert "(level has no number) in axis.friction" in first_sentence(report, UNITS)
    assert tables.parameters(report["parameters"], UNITS).rows[0][-1] == f"no number: {why}"


def test_a_law_is_an_equation_with_its_values():
    [law] = laws(made_up_report(), UNITS)

    assert law.equation == "F = value + F_c tanh(v / v_0)"
    assert law.values[0] == ["level", "Friction force F_c", "20.5 ± 0.12 N", "fitted"]
    assert law.values[1][3] == "held"


@pytest.mark.parametrize("name", sorted(listed()))
def test_every_effect_has_an_equation_for_the_report(name):
    assert "=" in equation_of(name)


def test_charts_take_the_place_of_their_panel_which_is_not_drawn_again_and_names_stay_text(tmp_path):
    (tmp_path / "axis_sealed.png").write_bytes(b"picture")
    t = np.arange(3.0)
    nasty = "</script><img src=x onerror=alert(1)>"
    chart = Chart(nasty, "time [s]", "force [N]", [Curve("measured", t, t, REFERENCE), Curve(nasty, t, t)])
    report = {
        "name": nasty,
        "verdict": "adequate",
        "sentence": nasty,
        "effects": [],
        "subsystem": None,
        "nominal": {},
        "before": {},
        "after": {},
        "explained_share": 0.0,
        "undistinguished": [],
        "runners_up": [],
        "parameters": {},
        "residual": {nasty: {"exact": True}},
        "channels": {nasty: CHANNEL},
        "recordings": {nasty: {"rows": 3, "period": 1e-3, "notes": [nasty]}},
        "files": [nasty],
    }

    text = page(report, [Panel(nasty, tmp_path / "axis_sealed.png", nasty, [chart, chart])], {})

    assert "<img src=x" not in text
    assert text.count("</script>") == 3
    assert text.count('<img class="picture"') == text.count("data:image/png;base64,cGljdHVyZQ==") == 1
    assert "image/svg+xml" not in text
    assert 'data-plots="axis_sealed"' in text
    assert "None was fitted." in text


def test_a_chart_is_in_the_order_of_time_and_does_not_bridge_missing_rows():
    found = curve("measured", np.array([0.7, 0.8, 0.0, 0.1, 0.2]), np.array([3.0, 4.0, 0.0, 1.0, 2.0]))

    assert found.x == pytest.approx([0.0, 0.1, 0.2, 0.45, 0.7, 0.8])
    assert np.flatnonzero(np.isnan(found.y)).tolist() == [3]
    assert found.y[[0, 1, 2, 4, 5]].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]


@pytest.fixture
def part():
    """Two signals of one FMU, the second with a residual of 3 Hz, which an effect halves."""
    t = np.arange(4000) * 1e-3
    left = np.stack([0.0 * t, np.sin(6.0 * np.pi * t)], axis=1)
    slot = SimpleNamespace(name="friction", unit="N", signals={"velocity": "m/s"})
    system = SimpleNamespace(
        descriptions={"axis": SimpleNamespace(by_name={"force": SimpleNamespace(unit_name="N")})},
        slots=lambda fmu: {"friction": slot},
    )
    bench = SimpleNamespace(
        outputs=["axis.other", "axis.force"],
        in_use=np.ones(len(t), dtype=bool),
        row_period=1e-3,
        period=1e-3,
        compared_rows=lambda values: values,
    )
    study = SimpleNamespace(measured=left, bench=bench, system=system, signals={})
    return SimpleNamespace(
        study=study,
        outputs=bench.outputs,
        in_use=bench.in_use,
        row_period=bench.row_period,
        base=SimpleNamespace(predicted=0.0 * left),
        fit=SimpleNamespace(predicted=0.5 * left),
        has_effect=True,
        correlations=[SimpleNamespace(basis="axis.velocity", value=-0.4, is_found=True)],
        chosen=SimpleNamespace(effects=[]),
    )


def test_the_residual_is_that_of_the_output_explained_worst_and_its_spectrum_shows_its_frequency(
    part, monkeypatch
):
    monkeypatch.setattr("master.diagnosis.answer.report.residual.worst_output", lambda study: 1)

    over_time, spectrum = residual_charts(part)

    assert [c.label for c in over_time.curves] == ["after", "before"]
    assert over_time.y_label == "residual [N]"
    after, before = spectrum.curves
    assert before.x[np.argmax(before.y)] == pytest.approx(3.0, abs=1.3)  # segments of 0.8 s
    assert after.y == pytest.approx(0.5 * before.y)
    for figure in (residual(part), where(part)):
        assert figure.get_layout_engine() is None  # one of Matplotlib's draws it twice
        figure.savefig(io.BytesIO())


def test_a_name_longer_than_the_page_leaves_room_for_its_bar(part, monkeypatch):
    monkeypatch.setattr("master.diagnosis.answer.report.residual.worst_output", lambda study: 1)
    part.correlations = [SimpleNamespace(basis=f"axis.{'velocity' * 30}", value=-0.4, is_found=True)]

    (figure,) = where(part).subfigs

    assert figure.axes[0].get_position().width > 0.2
