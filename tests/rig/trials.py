"""
Trials of the diagnosis on the virtual rig: many truths and seeds, one line of JSON each.

    python -m tests.rig.trials OUT.jsonl FIRST_SEED N_SEEDS [--workers N] [TRUTH ...]
    python -m tests.rig.trials_table OUT.jsonl ...

A truth is `none`, `none:colour`, `none:clock`, `none:plant`, an effect of the rig, or two joined by `+`; with
`:small` behind them they leave about as much as the noise, see SMALL. All truths come with one seed, then all
with the next; those in the file already are left out. Run it with OPENBLAS_NUM_THREADS=1.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import yaml

from master.diagnosis.answer.before_after import sealed
from master.diagnosis.answer.claims import claims, verdict
from master.diagnosis.answer.verdict import subsystem
from master.diagnosis.case.case import load_case
from master.diagnosis.judge.diagnose import diagnose
from master.diagnosis.replay.placed_effect import PlacedEffect
from tests.rig import SUBSYSTEM, Effects, Plant, Recorder, record
from tests.rig.trials_table import kinds_of, read

CASE = Path(__file__).parents[2] / "configs" / "measured" / "docking_rig.yaml"
SIZES = {
    **{"slack": 3e-3, "cubic": 2e8, "quadratic_stiffness": 5e5, "backlash": 5e-5, "bouc_wen": 5.0},
    **{"end_stop": 4e3, "coulomb": 4.0, "stribeck": 5.0, "dahl": 4.0, "presliding": 4.0},
    **{"asymmetric_friction": 5.0, "load_friction": 0.05, "ripple": 3.0, "force_limit": 80.0},
    **{"simulator_gain": 0.01, "quadratic_damping": 3e3, "offset": 1.0, "drift": 0.2, "mount": 1.0},
    **{"quantisation": 2.0, "gain": 0.02, "lag": 8e-3, "slow_filter": 8e-3, "delay": 8e-3, "inertia": 6.0},
    **{"rate_limit": 0.05, "speed_limit": 0.05, "simulator_delay": 2.0, "spacecraft_offset": 5.0},
    **{"command_quantisation": 2e-4, "correction_saturation": 60.0},
    **{"hertz": 2e5, "position_friction": 3.0, "thermal": 0.05, "preisach": 3.0},
    **{"asymmetric_slack": 3e-3, "varying_delay": 4e-3},
}
SMALL = {
    **{"cubic": 1.1e7, "quadratic_stiffness": 3.2e4, "backlash": 8e-6, "bouc_wen": 0.5, "end_stop": 380.0},
    **{"coulomb": 0.6, "stribeck": 0.6, "dahl": 0.6, "presliding": 0.5, "quadratic_damping": 1100.0},
    **{"asymmetric_friction": 0.8, "load_friction": 3.1e-3, "ripple": 0.24, "offset": 0.5, "drift": 0.075},
    **{"quantisation": 1.8, "simulator_gain": 1.6e-3, "mount": 0.25, "inertia": 1.5},
    **{"hertz": 5.4e3, "position_friction": 0.47, "thermal": 0.015, "preisach": 0.57},
}


def noise_of(recorder: Recorder) -> dict[str, float]:
    """Standard deviation of what is compared, by output."""
    names = ("force_sensor.f_mea", "motion_simulator.s_act", "motion_simulator.v_act")
    return dict(zip(names, (recorder.sigma, recorder.sigma_s, recorder.sigma_v), strict=True))


def one(truth: str, seed: int, folder: Path) -> dict:
    """Record, diagnose and judge."""
    rng = np.random.default_rng(1000 + seed)
    kinds = kinds_of(truth)
    sizes = SMALL if truth.endswith(":small") else SIZES
    effects = Effects(**{k: sizes[k] * rng.uniform(0.5, 1.5) for k in kinds})
    if "simulator_delay" in kinds:
        effects = effects._replace(simulator_delay=2.0)
    recorder, plant = Recorder(), Plant()
    if truth == "none:colour":
        recorder = Recorder(colour=0.9)
    if truth == "none:clock":
        recorder = Recorder(clock_error=1e-4 * rng.uniform(-1, 1))
    if truth == "none:plant":
        wrong = {n: getattr(plant, n) * rng.uniform(0.9, 1.1) for n in ("m_e", "k_m", "c_m", "k_p", "c_p")}
        plant = (plant._replace(**wrong), plant)
    recording = record(effects, seed=seed, recorder=recorder, plant=plant)
    recording.write(folder / "rig.npz")
    case = yaml.safe_load(CASE.read_text())
    case["system"] = str((CASE.parent / case["system"]).resolve())
    case["recordings"] = {"rich": {"file": str(folder / "rig.npz")}}
    (folder / "case.yaml").write_text(yaml.safe_dump(case))
    begin = time.perf_counter()
    with diagnose(load_case(folder / "case.yaml"), lambda _: None) as found:
        seconds = time.perf_counter() - begin
        return _judged(truth, seed, found, recorder, effects) | {"seconds": round(seconds, 1)}


def _judged(truth, seed, found, recorder, effects) -> dict:
    part = _part(found, {SUBSYSTEM[kind] for kind in kinds_of(truth)})
    files = {}
    for p in found.parts:
        chain = p.study.pool.player(p.chosen.effects).chain
        files |= {c.name: c.description.path for c in chain if c.name in p.fmus}
    name = part.name
    rows = sealed(found, files)
    own = rows[name]
    before, after = (_power(part, own, predicted) for predicted in (own.before, own.after))
    noise = noise_of(recorder)
    sized = zip(part.outputs, part.study.output_scale, strict=True)
    floor = float(np.mean([(noise.get(name, 0.0) / size) ** 2 for name, size in sized]))
    ideal = _rounding(part, own, effects) if effects.quantisation > 0.0 else floor
    return {
        "truth": truth,
        "seed": seed,
        "verdict": verdict(found, rows).value,
        "statuses": {str(c.placed): c.status.value for p in found.parts for c in claims(p, rows[p.name])},
        "effects": [f"{a.fmu}.{a.slot}:{a.effect}" for a in part.chosen.effects],
        "families": [list(f) for p in found.parts for f in p.families],
        "subsystem": subsystem(found),
        "before": before,
        "after": after,
        "share_of_ideal": (before - after) / max(before - ideal, 1e-300),
        "size_over_noise": float(np.sqrt(max(_unsealed(part) - floor, 0.0) / max(floor, 1e-300))),
        "others": [str(a) for p in found.parts if p is not part for a in p.chosen.effects],
    }


def _part(found, true):
    """The part with the effect that was found; where none was, the one that has it."""
    if found.main.chosen.effects:
        return found.main
    return next((p for p in found.parts if true & set(p.study.bench.part.fmus)), found.main)


def _power(part, own, predicted) -> float:
    return float(np.mean(((predicted - own.measured) / part.study.output_scale) ** 2))


def _unsealed(part) -> float:
    """Power that the refitted model without the effect leaves where an effect can be looked for."""
    rows = part.study.fit_rows.copy()
    for block in part.study.held_out:
        rows[block] = True
    left = part.base.predicted - part.study.measured
    return float(np.mean((left[rows] / part.study.output_scale) ** 2))


def _rounding(part, own, effects) -> float:
    """
    What the true model with its true numbers leaves where the sensor rounds: more than the noise.

    Its inputs were measured, and where the force is near the middle of a step their noise decides.
    """
    rows = np.round(own.t / part.row_period).astype(int)
    true = {f"contact.{n}": getattr(Plant(), n) for n in ("m_e", "k_m", "c_m", "k_p", "c_p")}
    placed = PlacedEffect("force_sensor", "output", "quantisation")
    values = true | {placed.variable("step"): effects.quantisation}
    return _power(part, own, part.study.simulate((placed,), values, everything=True)[rows])


def trial(truth: str, seed: int) -> dict:
    """One trial in a folder of its own; an error is a result too."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            return one(truth, seed, Path(folder))
        except Exception as error:
            return {"truth": truth, "seed": seed, "verdict": "error", "error": repr(error)[:300]}


def run(out: Path, first: int, count: int, truths: list[str], workers: int) -> None:
    """Run what is not in the file yet."""
    done = {(r["truth"], r["seed"]) for r in read([out])} if out.exists() else set()
    wanted = [(t, s) for s in range(first, first + count) for t in truths if (t, s) not in done]
    with ProcessPoolExecutor(workers, get_context("spawn")) as pool:
        for future in as_completed([pool.submit(trial, *w) for w in wanted]):
            with out.open("a") as file:
                file.write(json.dumps(future.result()) + "\n")


def main(arguments: list[str]) -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("out", type=Path)
    parser.add_argument("first", type=int)
    parser.add_argument("count", type=int)
    parser.add_argument("truths", nargs="*", default=["none", *SIZES])
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_intermixed_args(arguments)
    run(given.out, given.first, given.count, given.truths, given.workers)


if __name__ == "__main__":
    main(sys.argv[1:])
