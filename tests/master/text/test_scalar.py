import math

import pytest

from master.text.scalar import Plain, boolean_of, float_of, integer_of, number_of


@pytest.mark.parametrize(
    ("text", "number"),
    [
        ("010", 10),
        ("-3", -3),
        ("+3", 3),
        ("0o17", 15),
        ("0x1F", 31),
        ("1e-3", 0.001),
        ("-2E+4", -20000.0),
        (".5e1", 5.0),
        ("3.", 3.0),
        ("18446744073709551615", 2**64 - 1),
        (".inf", math.inf),
        ("-.INF", -math.inf),
    ],
)
def test_a_number_is_one_of_the_core_schema(text, number):
    assert number_of(Plain(text)) == number
    assert type(number_of(Plain(text))) is type(number)


def test_nan_is_a_number():
    assert math.isnan(number_of(Plain(".nan")))


@pytest.mark.parametrize(
    "text",
    [
        "1:30",
        "1_000",
        "yes",
        "true",
        "nan",
        "inf",
        "0b1",
        "0b_",
        "1e",
        ".",
        "",
        " 1",
        "1 ",
        "\u0661",
        "2001-99-99",
    ],
)
def test_other_words_are_no_numbers(text):
    with pytest.raises(ValueError, match="not a number"):
        number_of(Plain(text))


@pytest.mark.parametrize("value", [True, None, [], {}])
def test_what_is_no_text_and_no_number_is_none(value):
    with pytest.raises(ValueError, match="not a number"):
        number_of(value)


@pytest.mark.parametrize(("text", "value"), [("1" + "0" * 400, math.inf), ("-1" + "0" * 400, -math.inf)])
def test_a_number_beyond_all_floats_is_infinite(text, value):
    assert float_of(Plain(text)) == value


def test_a_number_of_5000_digits_is_refused():
    with pytest.raises(ValueError, match="a number of 5000 digits"):
        float_of(Plain("9" * 5000))


@pytest.mark.parametrize(("text", "value"), [("1e3", 1000), ("2.0", 2), ("9007199254740993", 2**53 + 1)])
def test_an_integer_may_be_written_as_a_float_and_keeps_its_digits(text, value):
    assert integer_of(Plain(text)) == value


@pytest.mark.parametrize("text", ["1.5", ".inf", ".nan"])
def test_a_part_of_one_is_no_integer(text):
    with pytest.raises(ValueError, match="not an integer"):
        integer_of(Plain(text))


@pytest.mark.parametrize("text", ["yes", "on", "1", "tRUE", ""])
def test_a_boolean_is_true_or_false_only(text):
    assert boolean_of(Plain("True"))
    with pytest.raises(ValueError, match="not true or false"):
        boolean_of(Plain(text))


@pytest.mark.parametrize(
    ("text", "shown"), [("10", "10"), ("true", "true"), ("fast", "'fast'"), ("010", "010"), ("~", "~")]
)
def test_a_message_shows_words_in_quotes(text, shown):
    assert Plain(text).shown == shown
