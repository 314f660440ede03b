"""The committed reference experiments are what the oracles give, and the models answer as they say."""

from __future__ import annotations

import io
import zipfile
from functools import cache
from xml.etree import ElementTree as ET

import numpy as np
import pytest

from fmu_sources.composed import registry
from fmu_sources.export.dependencies import influences
from fmu_sources.export.native_flavour import NativeSources, pack_native
from fmu_sources.export.reference_data import FOLDER, agreement, reference_files, reference_paths
from fmu_sources.framework.instance import Instance
from tests.oracles import make_references
from tests.oracles.reference_experiment import Experiment

LARGEST_FILE = 60_000
REPEATABLE = {"motion_simulator": 1e-8}  # its integrator chooses its steps; the others: rounding of libraries
SLOW = {"motion_simulator"}

each_model = pytest.mark.parametrize("name", make_references.MAKERS)
each_computed = pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=pytest.mark.long if n in SLOW else ()) for n in make_references.MAKERS],
)


@cache
def made(name: str) -> Experiment:
    return make_references.MAKERS[name]()


def read(content: bytes) -> np.ndarray:
    return np.genfromtxt(io.BytesIO(content), delimiter=",", names=True)


def answers(experiment: Experiment) -> np.ndarray:
    """Run the model source on the experiment, shape (rows, outputs)."""
    instance = Instance(registry.load(experiment.model))
    for name, value in experiment.parameters.items():
        instance[name] = value
    rows = []
    for k, t in enumerate(experiment.time):
        for name, column in experiment.inputs.items():
            instance[name] = float(column[max(k - 1, 0)])
        instance.step(experiment.time[k - 1], 1e-3) if k else instance.initialise(float(t))
        rows.append([float(instance[name]) for name in experiment.outputs])
    return np.array(rows)


@each_computed
def test_the_oracle_gives_the_committed_files(name):
    folder = make_references.folder_of(name)
    for file, content in made(name).files().items():
        committed = (folder / file).read_bytes()
        assert len(committed) <= LARGEST_FILE
        if not file.endswith("_out.csv"):
            assert content == committed
            continue
        new, old = read(content), read(committed)
        assert new.dtype.names == old.dtype.names
        for column in new.dtype.names:
            bound = REPEATABLE.get(name, 1e-13) * np.abs(old[column]).max()
            assert np.abs(new[column] - old[column]).max() <= bound, column


@each_computed
def test_the_model_gives_the_reference_outputs(name):
    experiment = made(name)
    got = answers(experiment)
    for column, (output, expected) in zip(got.T, experiment.outputs.items(), strict=True):
        bound = agreement(registry.load(name)) * float(np.abs(expected).max())

        assert np.abs(column - expected.astype(float)).max() <= bound, output


@each_computed
def test_every_output_moves(name):
    assert all(np.ptp(np.asarray(v, dtype=float)) > 0 for v in made(name).outputs.values())


@each_model
def test_the_fmu_carries_the_experiment_in_both_versions(name):
    model, file = registry.load(name), registry.model_files()[name]
    sources = NativeSources(model, "{token}", {}, reference_files(model, file))
    for version in ("2.0", "3.0"):
        with zipfile.ZipFile(io.BytesIO(pack_native(sources, {}, version))) as fmu:
            manifest = ET.fromstring(fmu.read(f"{FOLDER}/fmi-ls-manifest.xml"))
            files = {e.get("role"): fmu.read(f"{FOLDER}/{e.get('source')}") for e in manifest}
        experiment = ET.fromstring(files["experiment/smoke-test"])[0]

        assert set(files) == {"experiment/smoke-test", "parameter", "stimuli", "result"}
        assert (experiment.get("stopTime"), experiment.get("stepSize")) == ("0.25", "0.001")
        assert read(files["result"]).shape == read(files["stimuli"]).shape == (251,)


def test_a_rig_has_no_reference_experiment():
    name = "oscillator"

    assert reference_files(registry.load(name), registry.model_files()[name]) == {}


@each_computed
def test_the_columns_are_outputs_of_the_model_and_inputs_that_it_reads(name):
    model = registry.load(name)
    names = {v.name for v in model.all_variables}
    used = set().union(*influences(model).values()) & set(model.inputs.names)

    assert set(made(name).inputs) == used
    assert set(made(name).outputs) | set(made(name).parameters) <= names
    assert len(reference_paths(model, registry.model_files()[name])) == 3
