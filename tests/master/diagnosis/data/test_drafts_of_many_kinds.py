"""Recordings of twelve kinds, written by other libraries: each draft proposes a rig and passes as it is."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner

from fmu_sources.composed.registry import load
from fmu_sources.framework.variables import Role
from master.cli import main
from master.diagnosis.case.case import load_case
from master.diagnosis.data.draft import facts_of
from master.diagnosis.data.measured_signals import measured
from master.diagnosis.data.recordings import Column, read_rows
from master.diagnosis.data.rig_proposals import FOLLOWER, RIGS, Told, proposed
from master.errors import DataError

N = 3000
N_OF_BAG = 800  # messages are slow to write
T = np.arange(N) * 0.002
A = np.sin(2.1 * T) + 0.4 * np.sin(7.3 * T)
B = np.cos(2.1 * T) - 0.3 * np.sin(5.1 * T)
C = 0.5 * np.sin(1.3 * T + 1.0)


def text(path, rows, head, separator=",", comma=False, encoding="utf-8"):
    body = "\n".join(separator.join(row) for row in rows)
    path.write_text(head + (body.replace(".", ",") if comma else body) + "\n", encoding=encoding)


def rows_of(*columns):
    return [[f"{v:.6f}" for v in row] for row in zip(*columns, strict=True)]


def german_csv(path):
    head = "Prüfstand 3\nDatum;1.2.2025\nZeit;Druck A;Druck B;Weg\ns;bar;bar;mm\n"
    text(path, rows_of(T, 5 + A, 5 - A, 20 * B), head, ";", comma=True, encoding="latin-1")


def matlab_7_3(path):
    import h5py

    with h5py.File(path, "w", userblock_size=512) as file:
        for name, values in {"t": T, "current": A, "theta": B}.items():
            file.create_dataset(name, data=values[None, :])
    with open(path, "r+b") as file:
        file.write(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM")


def tdms(path):
    from nptdms import ChannelObject, TdmsWriter

    with TdmsWriter(str(path)) as file:
        for name, values, unit in (("time", T, "s"), ("voltage", A, "V"), ("omega", 50 * B, "rad/s")):
            file.write_segment([ChannelObject("run", name, values, {"unit_string": unit})])


def mdf(path):
    from asammdf import MDF, Signal

    file = MDF(version="4.10")
    file.append([Signal(v, T, name=n, unit=u) for n, v, u in (("phi", 90 * A, "deg"), ("M", 3 * B, "N m"))])
    file.save(path, overwrite=True)


def json_lines(path):
    rows = [
        {"time": round(60 * t, 4), "heater": {"power": 50 + 50 * a}, "temp": 300 + b}
        for t, a, b in zip(T, A, B, strict=True)
    ]
    path.write_text("\n".join(map(json.dumps, rows)), encoding="utf-8")


def parquet(path):
    import pandas as pd

    pd.DataFrame({"timestamp": T, "setpoint": A, "answer": C}).to_parquet(path)


def npz(path):
    np.savez(path, t=T, load_cell=A, stroke=B, state=np.full(N, "on"))


def hdf5(path):
    import h5py

    with h5py.File(path, "w") as file:
        group = file.create_group("plant")
        for name, values in {"time": 2000 * T, "pump_voltage": 3 + A, "level": 5 + B}.items():
            group[name] = values


def without_header(path):
    text(path, rows_of(T, A, B), "")


def short_print(path):
    lines = [f"{t:.2f}\t{a:.5f}\t{b:.5f}" for t, a, b in zip(T, A, C, strict=True)]
    path.write_text("# t\ttheta_ref [rad]\ttheta [rad]\n" + "\n".join(lines) + "\n", encoding="utf-8")


def iso_time_with_a_gap(path):
    begin = np.datetime64("2025-01-01T10:00:00.000")
    stamps = begin + (2 * np.arange(N) + 5000 * (np.arange(N) > 1000)).astype("timedelta64[ms]")
    rows = [[str(s), *row] for s, row in zip(stamps, rows_of(9 * A, 1 + 0.1 * C, B), strict=True)]
    text(path, rows, "stamp,x [mm],I [A],F [kN]\n")


def jitter(path):
    times = T + np.random.default_rng(1).uniform(-6e-4, 6e-4, N)
    path.write_text(
        json.dumps(
            {"time": (times - times[0]).tolist(), "beam_angle": A.tolist(), "ball_position": B.tolist()}
        ),
        encoding="utf-8",
    )


def bag(path, version):
    """Two topics with clocks of their own: a joint at 500 Hz, a load cell at 300 Hz."""
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC if version == 1 else Stores.ROS2_HUMBLE)
    types = store.types
    vector = types["geometry_msgs/msg/Vector3"]
    wrench = types["geometry_msgs/msg/Wrench"]
    stamped = types["geometry_msgs/msg/WrenchStamped"]
    joint = types["sensor_msgs/msg/JointState"]
    begin = 1_700_000_000 * 10**9
    none = np.zeros(0)

    def header(t):
        stamp = types["builtin_interfaces/msg/Time"](sec=int(t // 10**9), nanosec=int(t % 10**9))
        own = {"seq": 0} if version == 1 else {}
        return types["std_msgs/msg/Header"](stamp=stamp, frame_id="", **own)

    still = vector(x=0.0, y=0.0, z=0.0)
    messages = []
    for t, way in zip(T[:N_OF_BAG], B[:N_OF_BAG], strict=True):
        at = begin + round(t * 1e9)
        message = joint(header=header(at), name=["a"], position=np.array([way]), velocity=none, effort=none)
        messages.append((at + 300_000, "/joint_states", message))
    for t in np.arange(0.001, T[N_OF_BAG - 1], 1.0 / 300.0):
        at = begin + round(t * 1e9)
        force = wrench(force=vector(x=float(np.interp(t, T, A)), y=0.0, z=0.0), torque=still)
        messages.append((at + 700_000, "/load_cell", stamped(header=header(at), wrench=force)))
    writer = Writer1(path) if version == 1 else Writer2(path, version=8, storage_plugin=StoragePlugin.MCAP)
    with writer:
        pack = store.serialize_ros1 if version == 1 else store.serialize_cdr
        topics = {}
        for at, topic, message in sorted(messages, key=lambda entry: entry[0]):
            name = message.__msgtype__
            if topic not in topics:
                topics[topic] = writer.add_connection(topic, name, typestore=store)
            writer.write(topics[topic], at, pack(message, name))


def mdf_of_two_loggers(path):
    from asammdf import MDF, Signal

    file = MDF(version="4.10")
    file.append([Signal(B, T, name="stroke", unit="mm")])
    slower = T[:-1:2] + 0.0007
    file.append([Signal(np.interp(slower, T, A), slower, name="load", unit="kN")])
    file.save(path, overwrite=True)


KINDS = {
    "run.bag": (lambda path: bag(path, 1), "servo_axis_inverse"),
    "run": (lambda path: bag(path, 2), "servo_axis_inverse"),
    "loggers.mf4": (mdf_of_two_loggers, "servo_axis_inverse"),
    "german_csv.csv": (german_csv, "cylinder"),
    "matlab.mat": (matlab_7_3, "rotary_axis"),
    "motor.tdms": (tdms, "dc_motor"),
    "axis.mf4": (mdf, "rotary_axis_inverse"),
    "oven.jsonl": (json_lines, "thermal_body"),
    "loop.parquet": (parquet, "first_order_follower"),
    "press.npz": (npz, "servo_axis_inverse"),
    "tanks.h5": (hdf5, "two_tanks"),
    "bare.csv": (without_header, "first_order_follower"),
    "servo.txt": (short_print, "position_servo"),
    "damper.csv": (iso_time_with_a_gap, "controlled_damper"),
    "beam.json": (jitter, "ball_and_beam"),
}


def drafted(folder, kind):
    write, source = KINDS[kind]
    write(folder / kind)
    case = folder / "case.yaml"
    done = CliRunner().invoke(main, ["case", str(folder / kind), "--output", str(case)])
    assert done.exit_code == 0, done.output
    return case, source


@pytest.mark.parametrize("kind", KINDS)
def test_a_draft_proposes_the_rig_and_reads_the_recording(kind, tmp_path, monkeypatch):
    monkeypatch.setattr("master.diagnosis.data.columns_picture.draw_columns", lambda facts, path: path)
    case, source = drafted(tmp_path, kind)
    loaded = load_case(case)
    (model,) = loaded.case.fmus.values()

    assert model.source == source
    assert sum(map(len, measured(loaded).values())) > 0.95 * (N_OF_BAG if kind.startswith("run") else N)


PROPOSALS = {  # columns with their units, "" where none is told: source, and the column of each variable
    "all of a motor": (
        {"Voltage": "V", "Current": "A", "Angle": "deg", "Speed": "rpm"},
        "dc_motor",
        {"u": "Voltage", "i": "Current", "q": "Angle", "der_q": "Speed"},
    ),
    "a motor without its current": (
        {"u": "V", "phi": "rad", "omega": "rad/s"},
        "dc_motor",
        {"u": "u", "q": "phi", "der_q": "omega"},
    ),
    "a body in a room": (
        {"P_W": "", "T_room": "degC", "T_body": "degC"},
        "thermal_body",
        {"power": "P_W", "ambient": "T_room", "temperature": "T_body"},
    ),
    "an angle called q": (
        {"torque": "", "q": ""},
        "rotary_axis_inverse",
        {"torque": "torque", "q": "q"},
    ),
    "a pendulum with its gyroscope": (
        {"tau_cmd": "N m", "theta": "rad", "gyro": "deg/s"},
        "pendulum",
        {"torque": "tau_cmd", "q": "theta", "der_q": "gyro"},
    ),
    "two carriages": (
        {"force": "N", "x_drive": "mm", "x_load": "mm"},
        "two_masses",
        {"f": "force", "q_1": "x_drive", "q_2": "x_load"},
    ),
}


@pytest.mark.parametrize("of", PROPOSALS)
def test_the_rig_is_the_one_that_explains_most_columns(of):
    told, source, columns = PROPOSALS[of]
    found = proposed([Told(name, unit) for name, unit in told.items()])[0]

    assert found.rig.source == source
    assert found.columns == columns
    assert {*found.rig.drives, *found.compared} == set(columns)


def test_units_at_the_end_of_names_are_told_and_letters_of_places_are_not(tmp_path):
    head = "t_ms,travel_mm,load_kN,M_Nm,p_A,x_1\n"
    columns = (1000.0 * T, A, B, C, A, B)
    text(tmp_path / "run.csv", rows_of(*columns), head)

    facts = facts_of(tmp_path / "run.csv")

    told = {c.name: c.unit for c in facts.columns}
    assert told == {"travel_mm": "mm", "load_kN": "kN", "M_Nm": "N m", "p_A": "", "x_1": ""}
    assert facts.clock.unit == "ms"


def test_columns_of_two_clocks_of_a_file_are_brought_to_one(tmp_path):
    """The load is stamped 0.7 ms later than every second stroke: at a row it is what it was at that time."""
    case, _ = drafted(tmp_path, "loggers.mf4")
    (run,) = measured(load_case(case)).values()

    signal = next(v for v in run.signals.values() if np.abs(v).max() > 100.0)
    assert signal == pytest.approx(1e3 * np.interp(run.t, T, A), abs=1.0)  # N, of 1400


def test_a_bag_is_read_at_the_stamps_of_its_sensors(tmp_path):
    """Messages were recorded 0.3 and 0.7 ms after their stamps: 0.4 ms between the topics are 2 mN."""
    case, _ = drafted(tmp_path, "run")
    (run,) = measured(load_case(case)).values()

    assert run["force"] == pytest.approx(np.interp(run.t, T, A), abs=2e-4)


def test_columns_of_another_clock_are_refused_with_what_to_write(tmp_path):
    """Two loggers with as many rows as each other, half a row apart: no row is of one instant."""
    from asammdf import MDF, Signal

    file = MDF(version="4.10")
    file.append([Signal(B, T, name="stroke", unit="mm")])
    file.append([Signal(A, T + 0.001, name="load", unit="kN")])
    file.save(tmp_path / "two.mf4", overwrite=True)
    columns = {"way": Column("stroke", "mm"), "force": Column("load", "kN")}

    with pytest.raises(DataError) as caught:
        read_rows(tmp_path / "two.mf4", Column("0.time", "s"), columns)
    assert str(caught.value) == (
        f"{tmp_path / 'two.mf4'}: columns of force: got the clock '1.time', another one than '0.time', "
        "expected merge: {file: two.mf4, time: {column: '1.time'}, signals: [force]}"
    )


@pytest.mark.parametrize("rig", [*RIGS, FOLLOWER])
def test_a_proposal_drives_every_input_and_names_variables_of_its_model(rig):
    model = load(rig.source)
    outputs = {v.name for v in model.all_variables if v.output or v.role is Role.OUTPUT}

    assert {*rig.drives, *rig.rates, *rig.set} == set(model.inputs.names)
    assert {*rig.compared, *rig.also} <= outputs
    assert set(rig.refit) <= set(model.parameters.names)
    assert set(rig.states) <= set(model.states.names)


@pytest.mark.long
@pytest.mark.parametrize("kind", ["german_csv.csv", "oven.jsonl", "beam.json", "damper.csv"])
def test_a_draft_passes_its_check_as_it_is(kind, tmp_path):
    case, _ = drafted(tmp_path, kind)
    done = CliRunner().invoke(main, ["check", str(case)])

    assert done.exit_code == 0, case.read_text(encoding="utf-8") + done.stderr


def spring_or_mass(path, k, m):
    """Force of a spring of k, a damper and a mass m at the motion A; both rigs fit the columns alike."""
    x = 1e-3 * A
    v = np.gradient(x, T)
    force = k * x + 20.0 * v + m * np.gradient(v, T)
    text(path, rows_of(T, 1e3 * x, force), "t [s],travel [mm],force [N]\n")
    return path


@pytest.mark.parametrize(
    ("k", "m", "source", "other"),
    [
        (3e4, 0.0, "motion_driven_specimen", "servo_axis_inverse"),
        (0.0, 90.0, "servo_axis_inverse", "motion_driven_specimen"),
    ],
)
def test_of_rigs_that_fit_the_columns_alike_the_numbers_decide(k, m, source, other, tmp_path):
    case = tmp_path / "case.yaml"
    CliRunner().invoke(main, ["case", str(spring_or_mass(tmp_path / "run.csv", k, m)), "--output", str(case)])
    (model,) = load_case(case).case.fmus.values()

    assert model.source == source
    assert f"guess: the model; it may be {other}" in case.read_text(encoding="utf-8")


def test_a_constant_column_gives_the_value_that_is_seldom_recorded(tmp_path):
    rows = rows_of(T, 50.0 + 50.0 * A, 30.0 + B, np.full(N, 22.0), np.full(N, 7.0))
    text(tmp_path / "run.csv", rows, "t [s],heater [W],temp [degC],room [degC],number\n")
    case = tmp_path / "case.yaml"
    told = CliRunner().invoke(main, ["case", str(tmp_path / "run.csv"), "--output", str(case)])

    assert "never change: 'room [degC]' 22 degC, 'number' 7" in told.output
    (body,) = load_case(case).case.fmus
    assert float(load_case(case).case.set[f"{body}.ambient"]) == pytest.approx(295.15)


def test_the_clock_of_another_channel_that_is_the_same_is_no_column(tmp_path):
    from nptdms import ChannelObject, TdmsWriter

    clock = {"wf_increment": 0.002, "wf_start_offset": 0.0}
    with TdmsWriter(str(tmp_path / "run.tdms")) as file:
        file.write_segment([ChannelObject("run", name, v, clock) for name, v in (("ref", A), ("pos", B))])

    assert [c.name for c in facts_of(tmp_path / "run.tdms").columns] == ["ref", "pos"]
