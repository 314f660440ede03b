"""
What a worker of a cluster does: it hands runs to the process next to it, and their rows back.

Nothing but the standard library is loaded here: a worker's own thread must not wait for that.
"""

from __future__ import annotations

import pickle
import subprocess
import sys
import threading
import time

_stations: dict[tuple[str, int], subprocess.Popen[bytes]] = {}
_lock = threading.Lock()


def run_batch(packed: bytes, digest: str, given: bytes) -> tuple[float, bytes]:
    """
    Make some runs in the station of this thread.

    Args:
        packed: The bundle, for a station that begins.
        digest: Its SHA-256.
        given: The runs.

    Returns:
        The time that they took [s], and their rows.
    """
    began = time.monotonic()
    key = (digest, threading.get_ident())
    with _lock:
        station = _stations.get(key)
    if station is None or station.poll() is not None:
        station = subprocess.Popen(
            [sys.executable, "-m", "master.campaign.station"], stdin=subprocess.PIPE, stdout=subprocess.PIPE
        )
        with _lock:
            _stations[key] = station
        _put(station, packed)
    _put(station, given)
    assert station.stdout is not None
    rows: bytes = pickle.load(station.stdout)
    return time.monotonic() - began, rows


def _put(station: subprocess.Popen[bytes], content: bytes) -> None:
    assert station.stdin is not None
    pickle.dump(content, station.stdin)
    station.stdin.flush()
