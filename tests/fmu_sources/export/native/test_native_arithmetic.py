"""CasADi keeps every operation as the model writes it, so that C and Python agree bit for bit."""

from __future__ import annotations

import ctypes
import random
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from fmu_sources.export import native
from fmu_sources.framework.arithmetic import PYTHON, Arithmetic
from fmu_sources.framework.model import Model, SlotFunction, Values, no_effect
from fmu_sources.framework.variables import declare, input_, output, vector
from tests.fmu_sources.export.native.native_library import GUID

Expression = Callable[[Any, Any, Any, Arithmetic], Any]

# Each is one that CasADi or a compiler likes to rewrite; a and b are random, n is -3.0, -2.5, ... 3.0.
EXPRESSIONS: tuple[Expression, ...] = (
    lambda a, b, n, m: a / b * b,
    lambda a, b, n, m: a * b / b,
    lambda a, b, n, m: a - b + b,
    lambda a, b, n, m: (a + b) - a,
    lambda a, b, n, m: 0.1 * a * 10.0,
    lambda a, b, n, m: 3 * (0.1 * a),
    lambda a, b, n, m: a * (1.0 / b),
    lambda a, b, n, m: 1.0 / (1.0 / a),
    lambda a, b, n, m: a / 3.0 + b / 0.7,
    lambda a, b, n, m: a * b + a * b + 2.0 * a + 2.0 * a,
    lambda a, b, n, m: a * a * a,
    lambda a, b, n, m: 0.0 * a - a,
    lambda a, b, n, m: -(a - b) - (-a),
    lambda a, b, n, m: m.sqrt(a * a) + m.sqrt(m.fabs(b)) * m.sqrt(m.fabs(b)),
    lambda a, b, n, m: m.sin(a) * m.sin(a) + m.cos(a) * m.cos(a),
    lambda a, b, n, m: m.exp(-m.fabs(a)) + m.log(m.fabs(b)) + m.tan(a) + m.tanh(b),
    lambda a, b, n, m: m.sin(0.3) * a + m.exp(m.log(1.7)) * b + m.pi,
    lambda a, b, n, m: m.floor(a * 5.0) + m.floor(n),
    lambda a, b, n, m: m.where(a > b, -(0.0 * a), b),  # a zero keeps its sign; a literal -0.0 would not
    lambda a, b, n, m: m.where(m.both(a > 0.0, b >= a), a, m.where(n == 1.0, b, m.where(n != 2.0, -a, n))),
    lambda a, b, n, m: m.pick((a, b, 3.0, a * b), n),
    lambda a, b, n, m: m.pick((a,), n),
    lambda a, b, n, m: m.where(True, a, b) + abs(b),
)


class Expressions(Model):
    """All expressions as outputs."""

    name = "expressions"
    description = "Arithmetic."
    variables = declare(
        input_("a", "1", ""),
        input_("b", "1", ""),
        input_("n", "1", ""),
        vector(output("y", "1", ""), len(EXPRESSIONS)),
    )

    def outputs(
        self, t: Any, x: Any, u: Any, p: Any, m: Arithmetic, slot: SlotFunction = no_effect
    ) -> Values:
        return {"y": tuple(e(u.a, u.b, u.n, m) for e in EXPRESSIONS)}


def outputs_in_c(path: Path, inputs: list[float]) -> list[float]:
    """Call the generated function itself, which is hidden in an FMU."""
    numbers = (ctypes.c_double * 3)(*inputs)
    results = (ctypes.c_double * len(EXPRESSIONS))()
    ctypes.CDLL(str(path)).model_outputs(ctypes.c_double(0.0), None, numbers, None, results)
    return list(results)


@pytest.fixture(scope="module")
def path(tmp_path_factory: pytest.TempPathFactory) -> Path:
    sources = native.generate(Expressions(), GUID)
    text = sources["model.h"].replace(
        b"void model_outputs(", b'__attribute__((visibility("default"))) void model_outputs('
    )
    built = tmp_path_factory.mktemp("expressions") / "expressions.so"
    built.write_bytes(native.compile_host(sources | {"model.h": text}, "expressions"))
    return built


def test_every_expression_has_the_bits_of_python(path: Path) -> None:
    rng = random.Random(3)
    for _ in range(5000):
        a, b, n = rng.gauss(0.0, 1.0), rng.uniform(-1e3, 1e3), rng.randint(-6, 6) / 2.0
        expected = [float(e(a, b, n, PYTHON)) for e in EXPRESSIONS]
        got = outputs_in_c(path, [a, b, n])
        differ = [i for i in range(len(got)) if struct.pack("d", got[i]) != struct.pack("d", expected[i])]
        assert differ == []
