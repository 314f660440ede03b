import pytest

from tests.foreign.build import FOLDERS, compile_c, describe_2, describe_3, write_fmu


@pytest.fixture(scope="module")
def binaries(tmp_path_factory):
    return {v: compile_c(v, tmp_path_factory.mktemp("c" + v[0])) for v in FOLDERS}


@pytest.fixture
def fmu(binaries, tmp_path):
    def make(version, description=None):
        text = description or (describe_3() if version == "3.0" else describe_2())
        name = f"{FOLDERS[version]}/types.so"
        return write_fmu(tmp_path / f"types{version[0]}.fmu", text, {name: binaries[version]})

    return make
