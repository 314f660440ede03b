import numpy as np
import pytest
from numba import njit

from master.fmi.native.cells import LARGEST_SIZE, first_misfit, pack, unpack
from master.fmi.native.jit import tell_numba
from master.fmi.value_types import INT_BOOLEAN, NAMES

tell_numba()
LARGEST_FLOAT32 = float(np.finfo(np.float32).max)
_pack = njit(pack)
_unpack = njit(unpack)
FORMS = pytest.mark.parametrize("form", [(pack, unpack), (_pack, _unpack)], ids=["python", "compiled"])


def packed(form, kind, *values):
    scratch = np.zeros(LARGEST_SIZE * 4, dtype=np.uint8)
    table = np.array([99.0, *values])
    form[0](table[1:].ctypes.data, len(values), kind, scratch.ctypes.data)
    back = np.full(len(values) + 1, 99.0)
    form[1](back[1:].ctypes.data, len(values), kind, scratch.ctypes.data)
    return scratch, back.tolist()


@FORMS
@pytest.mark.parametrize("name", [n for n in NAMES if n != "Float64"])
def test_whole_numbers_pass_every_type_as_numpy_stores_them(form, name):
    values = [1.0, 0.0, 1.0] if name == "Boolean" else [1.0, 0.0, 120.0]
    scratch, back = packed(form, NAMES.index(name), *values)
    stored = scratch.view("uint8" if name == "Boolean" else name.lower())

    assert stored[:3].tolist() == values
    assert back == [99.0, *values]


@FORMS
@pytest.mark.parametrize("name", ["Int8", "Int16", "Int32", "Int64"])
def test_a_signed_type_keeps_the_sign(form, name):
    _, back = packed(form, NAMES.index(name), -100.0, 7.0)

    assert back == [99.0, -100.0, 7.0]


@pytest.mark.parametrize("find", [first_misfit, njit(first_misfit)], ids=["python", "compiled"])
@pytest.mark.parametrize(
    ("name", "least", "largest"),
    [
        ("Int8", -128.0, 127.0),
        ("UInt16", 0.0, 65535.0),
        ("Int64", 1.0 - 2.0**53, 2.0**53 - 1.0),
        ("Float32", -LARGEST_FLOAT32, LARGEST_FLOAT32),
    ],
)
def test_a_value_beyond_a_type_is_found(find, name, least, largest):
    kind, nan = NAMES.index(name), float("nan")

    fits = np.array([least, largest, 0.25])
    assert find(fits.ctypes.data, 3, kind) == -1
    for value in (np.nextafter(least - 0.5, -np.inf), 1.001 * largest + 1.0, nan, float("inf")):
        row = np.array([0.0, 0.0, value])
        assert find(row.ctypes.data, 3, kind) == 2


@pytest.mark.parametrize("name", ["Float64", "Boolean"])
def test_every_number_fits_the_other_types(name):
    row = np.array([1e300, float("nan")])
    assert first_misfit(row.ctypes.data, 2, NAMES.index(name)) == -1


@FORMS
def test_whole_numbers_round_to_the_nearest(form):
    _, back = packed(form, NAMES.index("Int32"), 0.6, -0.6, 2.5)

    assert back == [99.0, 1.0, -1.0, 2.0]


@FORMS
@pytest.mark.parametrize("kind", [NAMES.index("Boolean"), INT_BOOLEAN])
def test_whatever_is_not_zero_is_true(form, kind):
    _, back = packed(form, kind, 0.0, 0.25, -3.0)

    assert back == [99.0, 0.0, 1.0, 1.0]
