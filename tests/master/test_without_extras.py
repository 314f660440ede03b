"""Packages of extras are needed by the work that they are for, and by nothing else."""

from __future__ import annotations

import subprocess
import sys

import pytest

IMPORT_ALL = """
import importlib, pkgutil, sys

import dockloop
import master
from master.installation import EXTRAS

class Absent:
    absent = {module for extra in EXTRAS for module in extra.modules}

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in self.absent:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
for package in (master, dockloop):
    for module in pkgutil.walk_packages(package.__path__, package.__name__ + "."):
        if not module.name.endswith("__main__"):
            importlib.import_module(module.name)
"""


@pytest.mark.long
def test_every_module_can_be_imported_where_no_extra_is_installed():
    done = subprocess.run([sys.executable, "-c", IMPORT_ALL], capture_output=True, text=True)

    assert done.returncode == 0, done.stderr[-500:]
