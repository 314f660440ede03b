"""`dockloop commission`: a rig measured by a chirp, and what its compensator is told then."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import click

from master.api import prepare_to_run
from master.commissioning.beliefs import beliefs
from master.commissioning.chirp import Chirp
from master.commissioning.commission import Commissioned
from master.commissioning.commission import commission as fitted
from master.commissioning.commission_page import write_page
from master.commissioning.models import Knowledge
from master.commissioning.rig import Held, read_held, run_held
from master.comparison.methods import Method, chosen
from master.errors import ConfigError, Problem
from master.experiment.prepare import Request
from master.installation import configuration
from master.process.child import done_apart
from master.recording.whole_file import write_whole
from master.ssp.parameter_set import parameter_set

from .common import CONFIG, FLAVOUR, JSON, SET, VARIANT, answers_errors, print_json, say, show_building

POSITIVE = click.FloatRange(min=0.0, min_open=True)
BAND = 1.2
"""Highest frequency that is used, in terms of that of the chirp."""
MOST_OF_RATE = 0.2
"""Highest frequency that is used in terms of the sampling rate: the noise is seen above it."""
OF_FMUS = {"interpolations": 2.0, "spread": 0.01, "force_zero": 0.0}
"""How often signals are interpolated on their way through the FMUs of contact and sensor; a sensor's zero."""


@click.command()
@CONFIG
@VARIANT
@SET
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Recording of a rig, columns time [s], s_cmd, s_act [m], f_mea [N]; without it the FMUs are it.",
)
@click.option(
    "--method", default="robust", show_default=True, metavar="METHOD", help="Whose parameters are written."
)
@click.option(
    "--amplitude", type=POSITIVE, default=Chirp.amplitude, show_default=True, help="Of the chirp [m]."
)
@click.option(
    "--duration", type=POSITIVE, default=Chirp.duration, show_default=True, help="Of the chirp [s]."
)
@click.option("--highest", type=POSITIVE, default=15.0, show_default=True, help="Its highest frequency [Hz].")
@click.option(
    "--stiffness-ratio", type=POSITIVE, default=0.01, show_default=True, help="How well k_m/k_p is known."
)
@click.option(
    "--damping-ratio", type=POSITIVE, default=0.01, show_default=True, help="How well c_m/c_p is known."
)
@click.option(
    "--force-zero",
    type=click.FloatRange(min=0.0),
    metavar="N",
    help="How well the measured force is known to be 0 where s_act is 0 and the contact bears nothing [N]; "
    "by default exactly for FMUs, and not at all for a recording.",
)
@FLAVOUR
@click.option(
    "--output",
    type=click.Path(path_type=Path, dir_okay=False),
    metavar="FILE",
    help="Parameter set (.ssv) to write; the page and the chirp go next to it.",
)
@JSON
@answers_errors
def commission(
    config: Path,
    record: Path | None,
    method: str,
    output: Path | None,
    as_json: bool,
    **options: Any,
) -> None:
    """Measure the rig of CONFIG by a chirp, spacecraft held: parameters with deviations for a compensator."""
    target = _target(method)
    ratios = {name: options.pop(name) for name in ("stiffness_ratio", "damping_ratio")}
    zero = options.pop("force_zero")
    highest = options.pop("highest")
    chirp = Chirp(options.pop("amplitude"), options.pop("duration"), highest=highest)
    request = Request(**options)
    if not chirp.lowest < highest:
        got = f"{highest:g} Hz"
        raise ConfigError(
            [Problem("too low", where="--highest", got=got, expected=f"above {chirp.lowest} Hz")]
        )
    held = None if record is None else read_held(record)
    answer = done_apart(lambda: _held(configuration(config), request, chirp, held))
    if BAND * highest > MOST_OF_RATE / answer.held.period:
        got = f"{highest:g} Hz with a sample every {answer.held.period:g} s"
        wanted = f"at most {MOST_OF_RATE / BAND / answer.held.period:.4g} Hz"
        raise ConfigError([Problem("too high for the samples", where="--highest", got=got, expected=wanted)])
    of_rig = OF_FMUS if record is None else {}
    if zero is not None:
        of_rig = {**of_rig, "force_zero": zero}
    knowledge = Knowledge(answer.held.period, **ratios, **of_rig)
    found = fitted(answer.held, answer.believed, BAND * highest, knowledge)
    told = {name: value for name, value in found.parameters().items() if name in target.takes()}
    file = output or Path("results") / answer.name / "parameters.ssv"
    page = file.with_name("commission.html")
    stimulus = file.with_name("chirp.csv")
    write_whole(file, parameter_set(told))
    write_whole(stimulus, _stimulus(chirp, answer.held.period))
    write_page(answer.name, method, answer.held, found, told, page)
    if as_json:
        files = {"parameters": str(file), "page": str(page), "chirp": str(stimulus)}
        print_json(_as_dict(answer.name, found, told, files))
        return
    for line in _lines(answer.name, found, told):
        say(line)
    say(f"parameters: {file}, page: {page}, the chirp to play: {stimulus}")


class _Answer(NamedTuple):
    """What comes back from the process that calls the FMUs."""

    name: str
    held: Held
    believed: dict[str, float]


def _held(config: Path, request: Request, chirp: Chirp, held: Held | None) -> _Answer:
    experiment = prepare_to_run(config, request, show_building)
    return _Answer(experiment.name, held or run_held(experiment, chirp), beliefs(experiment))


def _target(name: str) -> Method:
    found = chosen(name)
    if len(found) != 1:
        raise ConfigError([Problem("more than one method", where="--method", got=name, expected="one")])
    return found[0]


def _stimulus(chirp: Chirp, period: float) -> str:
    """Return the chirp as CSV: what is added to the command at rest."""
    rows = [f"{k * period:.9g},{value:.9g}" for k, value in enumerate(chirp.samples(period))]
    return "\n".join(['"time","s_cmd"', *rows, ""])


def _as_dict(name: str, found: Commissioned, told: dict[str, float], files: dict[str, str]) -> dict[str, Any]:
    return {
        "name": name,
        "values": {value.name: value.as_dict() for value in found.values},
        "noise": found.contact.noise,
        "ratio": {"plant": found.plant.ratio, "contact": found.contact.ratio},
        "swing": found.swing,
        "warnings": list(found.warnings),
        "parameters": told,
        "files": files,
    }


def _lines(name: str, found: Commissioned, told: dict[str, float]) -> list[str]:
    lines = [f"{name}: force swing {found.swing:.1f} N, noise {found.contact.noise:.3g} N"]
    lines += [
        f"  {value.name:<10}{value.value:>14.6g} +- {value.deviation:<10.2g}{value.unit:<7}{value.meaning}"
        for value in found.values
    ]
    lines += [f"  warning: {warning}" for warning in found.warnings]
    told_text = ", ".join(f"{key}: {value:.6g}" for key, value in told.items())
    return [*lines, f"  parameters: {{{told_text}}}"]
