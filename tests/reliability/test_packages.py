"""The wheel is reproducible; the bill of materials names all that a run loads."""

from __future__ import annotations

import pytest

from tests.reliability.packages import bill_of_materials, digest, oldest, requirements, wheel


def test_the_bill_of_materials_names_every_dependency_with_its_version():
    bill = bill_of_materials()
    names = {one["name"].lower() for one in bill["components"]}

    assert {name.lower() for name, _ in requirements()} <= names
    assert "llvmlite" in names  # that numba needs
    assert all(one["version"] and one["licenses"][0]["license"]["name"] for one in bill["components"])


def test_every_dependency_has_a_lower_bound_that_can_be_installed():
    assert "numpy==2.1.3" in oldest()
    assert "lxml~=5.3.0" in oldest()
    assert "fmpy==0.3.26" in oldest()
    assert len(oldest()) == len(requirements())


@pytest.mark.long
def test_the_wheel_built_twice_has_the_same_bytes(tmp_path):
    assert digest(wheel(tmp_path / "one")) == digest(wheel(tmp_path / "two"))
