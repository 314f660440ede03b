"""A search that has to end: where it may be stopped, and where not."""

from __future__ import annotations

import pytest

from master.diagnosis.search.deadline import Deadline, TimeIsUpError


def test_a_search_is_stopped_once_and_what_follows_is_not():
    seen = []
    deadline = Deadline(budget=0.0)
    show = deadline.watched(seen.append)

    show("replay")
    deadline.arm()
    with pytest.raises(TimeIsUpError):
        show("fit of a")
    show("last fit")

    assert seen == ["replay", "fit of a", "last fit"]
    assert deadline.has_stopped


def test_without_a_budget_nothing_stops_it():
    deadline = Deadline()
    show = deadline.watched(lambda text: None)
    deadline.arm()

    show("fit of a")
    show("fit of b")

    assert not deadline.has_stopped
