"""Write the recording of docking_rig.yaml: python tests/rig/write.py [EFFECT=SIZE ...] [PATH]."""

from __future__ import annotations

import sys
from pathlib import Path

from tests.rig import Effects, record

DEFAULT = Path(__file__).parents[2] / "configs" / "measured" / "recordings" / "docking_rig.csv"


def main(arguments: list[str]) -> None:
    sizes = {name: float(size) for name, _, size in (a.partition("=") for a in arguments if "=" in a)}
    path = next((Path(a) for a in arguments if "=" not in a), DEFAULT)
    path.parent.mkdir(parents=True, exist_ok=True)
    record(Effects(**(sizes or {"coulomb": 4.0}))).write(path)


if __name__ == "__main__":
    main(sys.argv[1:])
