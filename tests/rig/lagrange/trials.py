"""
Trials of the diagnosis on the second rig, on demand: one line of JSON each, and the table of all.

    python -m tests.rig.lagrange.trials OUT.jsonl FIRST_SEED N_SEEDS [TRUTH ...]
    python -m tests.rig.lagrange.trials OUT.jsonl --sample N
    python -m tests.rig.lagrange.trials --table OUT.jsonl

A truth is the name of a law, two of them joined by `+`, a fault of the compensator, or `none:` and a
nuisance; all of them if none is named. A law comes with a nuisance that goes with the seed; a fault with
those alone that leave what the compensator read as it is. Those in the file already are left out. The
sample is drawn once and for all, with its classes in turn, and its first N are tried: however many there is
time for, they are a fair sample of each class. Run it with OPENBLAS_NUM_THREADS=1.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from pathlib import Path

import numpy as np
import yaml
from scipy.stats import beta, norm

from master.diagnosis.answer.answer import answer
from tests.rig.lagrange.laws import FAULTS, LAWS, LISTED, PAIRS, Law
from tests.rig.lagrange.recording import NONE, NUISANCES, record, true_body

CASE = Path(__file__).parents[3] / "configs" / "measured" / "docking_rig.yaml"
SILENT = ("nothing missing", "parameters only")
CONFIDENT = ("traced", "one of a class")
PARTLY = "partly, with a remainder"
SOFTWARE = "fault of a software part"
SURE = 0.95
SAMPLE_SEED = 17
SAMPLE_SEEDS = range(100, 200)
TWO_SIDED = float(norm.ppf(0.5 + 0.5 * SURE))
NUMBERS = {
    "contact.m_e": "m_e",
    "contact.k_m": "k_m",
    "contact.c_m": "c_m",
    "contact.k_p": "k_p",
    "contact.c_p": "c_p",
    "motion_simulator.K_p": "position_gain",
    "motion_simulator.w_v": "velocity_bandwidth",
    "motion_simulator.z": "velocity_damping",
    "spacecraft.m_s": "m_s",
}
"""Parameters of the models to those of the rig."""
AS_READ = ("white", "pink", "hum", "spikes", "bits", "off")  # nuisances that the compensator reads too


def truths() -> list[str]:
    """All truths, those without an effect first."""
    return [f"{NONE}:{name}" for name in NUISANCES] + [*FAULTS, *LISTED, *PAIRS, *LAWS]


def sample(n: int) -> list[tuple[str, int]]:
    """Return the first `n` truths, with seeds, of a sample in which the classes take turns."""
    rng = np.random.default_rng(SAMPLE_SEED)
    classes = [[f"{NONE}:{name}" for name in NUISANCES], [*LAWS], [*LISTED], [*FAULTS], [*PAIRS], [*LAWS]]
    drawn: list[tuple[str, int]] = []
    while len(drawn) < n:
        for names in classes:
            left = [(name, seed) for name in names for seed in SAMPLE_SEEDS if (name, seed) not in drawn]
            drawn.append(left[int(rng.integers(len(left)))])
    return drawn[:n]


def laws_of(truth: str) -> list[Law]:
    """Laws that a truth has; none where nothing is wrong, or software is."""
    return [(LAWS | LISTED)[name] for name in truth.split("+") if name in LAWS or name in LISTED]


def nuisance_of(truth: str, seed: int) -> str:
    """The nuisance that a truth names, or the one that goes with the seed."""
    law, _, nuisance = truth.partition(":")
    possible = AS_READ if law in FAULTS else tuple(NUISANCES)
    return nuisance or possible[seed % len(possible)]


def write_case(folder: Path, truth: str, seed: int) -> Path:
    """Record a truth, and write the case of the first rig with all effects allowed in its slots."""
    rng = np.random.default_rng(7000 + seed)
    law = truth.partition(":")[0]
    nuisance = nuisance_of(truth, seed)
    record(law, rng.uniform(0.6, 1.4), nuisance=nuisance, seed=seed).write(folder / "rig.npz")
    case = yaml.safe_load(CASE.read_text())
    case["system"] = str((CASE.parent / case["system"]).resolve())
    case["recordings"] = {"rich": {"file": "rig.npz"}}
    case["slots"] = dict.fromkeys(case["slots"], "all")
    path = folder / "case.yaml"
    path.write_text(yaml.safe_dump(case))
    return path


def trial(truth: str, seed: int) -> dict:
    """One trial; an error is a result too."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        begin = _processor_seconds()
        try:
            report = answer(write_case(folder, truth, seed), folder / "out", lambda _: None)
        except Exception as error:
            return {"truth": truth, "seed": seed, "verdict": "error", "error": repr(error)[:300]}
        return {
            "truth": truth,
            "seed": seed,
            "verdict": report["verdict"],
            "subsystem": report["subsystem"],
            "effects": [f"{e['fmu']}.{e['slot']}: {e['effect']} ({e['status']})" for e in report["effects"]],
            "families": [u["family"] for u in report["undistinguished"]],
            "faults": [f["kind"] for f in report["faults"]],
            "sentence": report["sentence"],
            "explained": report["explained_share"],
            "ceiling": report["ceiling"]["share"],
            "before": {k: v["rmse"] for k, v in report["before"].items()},
            "after": {k: v["rmse"] for k, v in report["after"].items()},
            "numbers": _numbers(report, nuisance_of(truth, seed), seed),
            "processor_seconds": round(_processor_seconds() - begin, 1),
        }


def _numbers(report: dict, nuisance: str, seed: int) -> dict[str, list[float]]:
    """True value, identified value and its standard deviation of all parameters that have a number."""
    true = true_body(nuisance, seed)
    known = {k: v for k, v in report["parameters"].items() if k in NUMBERS and not v["no_number"]}
    return {
        k: [getattr(true, NUMBERS[k]), v["with_effect"], v["deviation"]]
        for k, v in known.items()
        if not v["at_bound"]
    }


def _processor_seconds() -> float:
    """Processor time of this process and of its children that have ended, compilers among them."""
    return sum(os.times()[:4])


def is_silent(row: dict) -> bool:
    """Whether nothing was said to be missing."""
    return row["verdict"] in SILENT


def is_named(row: dict) -> bool:
    """Whether a name was given with confidence; no law of `LAWS` has one."""
    return row["verdict"] in CONFIDENT or any(e.endswith("(traced)") for e in row.get("effects", []))


def told(row: dict) -> list[str]:
    """Effects that were named or may be what is missing, as `fmu.slot: effect`."""
    names = [e.rpartition(" (")[0] for e in row.get("effects", [])]
    return names + [part for family in row.get("families", []) for m in family for part in m.split(" and ")]


def is_told(row: dict, law: Law) -> bool:
    """Whether a listed law has its right name in its FMU, alone or in its class."""
    return any(
        name.partition(".")[0] == law.subsystem and name.rpartition(": ")[2] in law.names
        for name in told(row)
    )


def is_right(row: dict) -> bool:
    """Whether a truth of one listed law was told."""
    return all(is_told(row, law) for law in laws_of(row["truth"]))


def is_right_of_two(row: dict) -> bool:
    """Whether both of two were told, or one and a remainder."""
    n = sum(is_told(row, law) for law in laws_of(row["truth"]))
    return n == 2 or (n == 1 and row["verdict"] == PARTLY)


def is_of_kind(row: dict) -> bool:
    """Whether the kind of a fault was told."""
    return any(FAULTS[row["truth"]] in kind for kind in row.get("faults", []))


def is_right_in_all(row: dict) -> bool:
    """Whether every effect that was called traced is there, in its FMU."""
    laws = laws_of(row["truth"])
    traced = [e.rpartition(" (")[0] for e in row.get("effects", []) if e.endswith("(traced)")]
    return all(any(is_told({"effects": [f"{e} (traced)"]}, law) for law in laws) for e in traced)


def is_worse(row: dict) -> bool:
    """Whether a corrected model was handed over that leaves a channel worse on the sealed part."""
    pairs = [(v, row["after"][k]) for k, v in row.get("before", {}).items()]
    known = [(b, a) for b, a in pairs if b is not None and a is not None]
    exported = [e for e in row.get("effects", []) if not e.endswith("(not confirmed)")]
    return bool(exported) and any(a > 1.001 * b for b, a in known)


def has_right_model(row: dict) -> bool:
    """Whether nothing is missing, or all that is was named and nothing else: its numbers are the truth's."""
    laws = laws_of(row["truth"])
    if row["truth"].startswith(NONE) or row["truth"] in FAULTS:
        return not row.get("effects")
    is_listed = bool(laws) and all(law.names for law in laws)
    return is_listed and len(row.get("effects", [])) == len(laws) and is_right(row)


def holds(true: float, value: float, deviation: float) -> bool:
    """Whether the 95 % interval of a number holds the true one."""
    return abs(value - true) <= TWO_SIDED * deviation


def coverage(rows: list[dict]) -> list[dict]:
    """Every number of models that are right, in all rows: its trial, its name and whether it is held."""
    return [
        {"truth": row["truth"], "seed": row["seed"], "number": name, "is_held": holds(*number)}
        for row in rows
        if has_right_model(row)
        for name, number in row.get("numbers", {}).items()
    ]


def interval(count: int, n: int) -> tuple[float, float]:
    """95 % interval of a share by Clopper and Pearson (1934), of `count` in `n`."""
    tail = 0.5 * (1.0 - SURE)
    low = float(beta.ppf(tail, count, n - count + 1)) if count else 0.0
    high = float(beta.ppf(1.0 - tail, count + 1, n - count)) if count < n else 1.0
    return low, high


def table(rows: list[dict]) -> str:
    """Counts with intervals against their bounds, and every trial's outcome, in Markdown."""
    done = [r for r in rows if r["verdict"] != "error"]
    none = [r for r in done if r["truth"].startswith(NONE)]
    unlisted = [r for r in done if r["truth"] in LAWS]
    one = [r for r in done if r["truth"] in LISTED]
    two = [r for r in done if "+" in r["truth"]]
    software = [r for r in done if r["truth"] in FAULTS]
    laws = [*unlisted, *one, *two]
    traced = [r for r in done if any(e.endswith("(traced)") for e in r["effects"])]
    cost = [r["processor_seconds"] for r in rows if "processor_seconds" in r]
    lines = ["| check | bound | count | 95 % interval |", "|---|---|---|---|"]
    checks = (
        ("no effect: claimed", "<= 2 %", none, lambda r: not is_silent(r)),
        ("listed: right name, or its class with it", ">= 95 %", one, is_right),
        ("undeclared: detected", ">= 95 %", unlisted, lambda r: not is_silent(r)),
        ("undeclared: named with confidence", "<= 3 %", unlisted, is_named),
        ("two effects: both, or one and a remainder", ">= 85 %", two, is_right_of_two),
        ("fault of software: detected", "all", software, lambda r: r["verdict"] == SOFTWARE),
        ("fault of software: kind right", ">= 80 %", software, is_of_kind),
        ("traced: right in all that is called so", ">= 97 %", traced, is_right_in_all),
        ("after worse than before, yet exported", "0", rows, is_worse),
        ("explained <= ceiling + 0.05", "all", laws, lambda r: r["explained"] <= r["ceiling"] + 0.05),
        ("ended in an error", "0", rows, lambda r: r["verdict"] == "error"),
    )
    numbers = coverage(done)
    checks += (("95 % intervals hold the truth", "90 to 99 %", numbers, lambda n: n["is_held"]),)
    for what, bound, own, counted in checks:
        if own:
            count = sum(map(counted, own))
            low, high = interval(count, len(own))
            lines.append(f"| {what} | {bound} | {count}/{len(own)} | {100 * low:.0f} to {100 * high:.0f} % |")
    lines += ["", "| truth | seed | verdict | effects |", "|---|---|---|---|"]
    lines += [
        f"| {r['truth']} | {r['seed']} | {r['verdict']} | {'; '.join(r.get('effects', []))} |" for r in rows
    ]
    missed = [f"{n['number']} ({n['truth']} {n['seed']})" for n in numbers if not n["is_held"]]
    if missed:
        lines += ["", f"Numbers whose 95 % interval misses the truth: {'; '.join(missed)}."]
    if cost:
        lines += [
            "",
            f"Processor time of a trial: {np.median(cost):.0f} s in the median, {max(cost):.0f} s at most.",
        ]
    return "\n".join(lines)


def main(arguments: list[str]) -> None:
    """Run trials, or print their table."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--table", action="store_true")
    parser.add_argument("out", type=Path)
    parser.add_argument("first", type=int, nargs="?", default=1)
    parser.add_argument("count", type=int, nargs="?", default=1)
    parser.add_argument("--sample", type=int, metavar="N")
    parser.add_argument("truths", nargs="*")
    given = parser.parse_args(arguments)
    rows = [json.loads(line) for line in given.out.read_text().splitlines()] if given.out.exists() else []
    if given.table:
        sys.stdout.write(f"{table(rows)}\n")
        return
    done = {(r["truth"], r["seed"]) for r in rows}
    seeds = range(given.first, given.first + given.count)
    wanted = [(truth, seed) for seed in seeds for truth in given.truths or truths()]
    for truth, seed in wanted if given.sample is None else sample(given.sample):
        if (truth, seed) not in done:
            row = trial(truth, seed)
            with given.out.open("a") as file:
                file.write(json.dumps(row) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
