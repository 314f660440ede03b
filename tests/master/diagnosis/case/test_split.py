from __future__ import annotations

import pytest

from master.diagnosis.case.split import Stretch, blocks, by_blocks, by_recording, with_sealed_recordings
from master.errors import DataError


def test_recordings_go_to_the_parts_by_name():
    split = by_recording({"a": 10, "b": 20, "c": 30}, {"fit": ["a"], "select": ["b"], "sealed": ["c"]})

    assert split.fit == (Stretch("a", 0, 10),)
    assert split.sealed.open() == (Stretch("c", 0, 30),)


def test_sealed_part_is_read_once():
    sealed = by_blocks({"a": 90}, ["fit", "select", "sealed"], 1).sealed
    sealed.open()

    with pytest.raises(RuntimeError, match="read before"):
        sealed.open()


def test_blocks_of_different_use_have_a_guard_between_them():
    split = by_blocks({"a": 100}, ["fit", "fit", "select", "fit", "sealed"], 5)

    assert split.fit == (Stretch("a", 0, 40), Stretch("a", 65, 80))
    assert split.select == (Stretch("a", 45, 60),)
    assert split.sealed.open() == (Stretch("a", 85, 100),)


def test_blocks_cover_recordings_to_their_end_where_others_are_sealed():
    split = with_sealed_recordings({"a": 90, "b": 7}, ["fit", "select", "fit"], 0, ["b"])

    assert split.fit == (Stretch("a", 0, 30), Stretch("a", 60, 90))
    assert split.sealed.open() == (Stretch("b", 0, 7),)


def test_stretches_are_cut_into_contiguous_blocks():
    assert blocks([Stretch("a", 0, 100), Stretch("b", 10, 60)], 3) == [
        Stretch("a", 0, 50),
        Stretch("a", 50, 100),
        Stretch("b", 10, 60),
    ]


def test_faults_of_a_split_are_reported_together():
    with pytest.raises(DataError) as caught:
        by_recording({"a": 10}, {"fit": ["a", "a"], "select": ["b"]})

    assert str(caught.value).splitlines() == [
        "split.sealed: got no recording, expected at least one",
        "split: no such recording, got 'b', expected one of ['a']",
        "split: 'a' is there twice, expected once",
    ]


def test_short_blocks_and_missing_parts_are_refused():
    with pytest.raises(DataError, match="too short for a guard of 60 rows"):
        by_blocks({"a": 100}, ["fit", "select", "sealed"], 60)
    with pytest.raises(DataError, match="no block for 'sealed'"):
        by_blocks({"a": 100}, ["fit", "select"], 1)
