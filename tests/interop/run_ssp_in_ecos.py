"""Run in an environment with ecospy: an SSP archive, steps and signals in, last values (JSON) out."""

from __future__ import annotations

import json
import sys

from ecospy import EcosSimulation


def main(archive: str, n_steps: str, *signals: str) -> None:
    with EcosSimulation(ssp_path=archive, step_size=1e-3) as simulation:
        assert simulation.init(parameter_set="initialValues")
        for _ in range(int(n_steps)):
            simulation.step()
        found = {s: simulation.get_real(s.replace(".", "::", 1)) for s in signals}
        sys.stdout.write(json.dumps(found) + "\n")
        simulation.terminate()


if __name__ == "__main__":
    main(*sys.argv[1:])
