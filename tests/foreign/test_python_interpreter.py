"""
Libraries of PythonFMU and PythonFMU3 hold an interpreter that they release twice at the end of a process.

A static `shared_ptr` is destroyed by `exit`, and the library's destructor then sets it to null. Whether the
heap shows that is chance, so the test asks for what prevents it: the release while both are alive.
"""

import pytest

from master.fmi.description import read_description
from master.stepping.simulate import load

from .build import FOLDERS, HERE, compile_c, describe_2, describe_3, write_fmu

RELEASE = """
#include <stdio.h>
void finalizePythonInterpreter(void) { fclose(fopen(getenv("RELEASED"), "a")); }
"""


@pytest.mark.parametrize("version", ["2.0", "3.0"])
def test_the_interpreter_of_a_library_is_released_with_its_instance(version, tmp_path, monkeypatch):
    released = tmp_path / "released"
    monkeypatch.setenv("RELEASED", str(released))
    source = tmp_path / "source.c"
    source.write_text((HERE / f"types{version[0]}.c").read_text() + RELEASE)
    library = compile_c(version, tmp_path, source)
    text = describe_3() if version == "3.0" else describe_2()
    file = write_fmu(tmp_path / "types.fmu", text, {f"{FOLDERS[version]}/types.so": library})
    slave = load("python", read_description(file))
    assert not released.exists()
    slave.close(failed=False)

    assert released.exists()
