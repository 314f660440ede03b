"""FMPy loads FMUs by the signatures of its functions; that they are kept changes none of them."""

from __future__ import annotations

import inspect

from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from master.fmi.signatures import keep_signatures


def test_the_signatures_that_are_kept_are_those_of_the_functions():
    for kind in (FMU2Slave, FMU3Slave):
        keep_signatures(kind)
        functions = [f for name, f in inspect.getmembers(kind, inspect.isfunction) if name.startswith("fmi")]

        assert len(functions) > 25
        for function in functions:
            kept = vars(function)["__signature__"]
            code = function.__code__
            assert list(kept.parameters) == list(code.co_varnames[: code.co_argcount])
            assert kept.return_annotation is function.__annotations__.get("return", inspect.Signature.empty)
