import ctypes
import gc
import resource
import sys

import pytest

from master.fmi import logger
from master.fmi.messages import LogFile, MessageLog
from master.process import position
from master.process.position import MAKING_A_STEP, PHASE, TICK, Position

POINTER, DOUBLE, INT, TEXT = ctypes.c_void_p, ctypes.c_double, ctypes.c_int, ctypes.c_char_p


@pytest.fixture
def said():
    """Call the logger of FMI 2.0 as an FMU does, with variable arguments; returns what arrives."""
    heard = []
    environment = logger.add(lambda *what: heard.append(what))

    def call(form, *arguments, status=3, category=b"cat"):
        function = ctypes.CFUNCTYPE(None)(logger.address())
        function(POINTER(environment), TEXT(b"a"), INT(status), TEXT(category), form, *arguments)
        return heard.pop()

    yield call
    logger.remove(environment)


def test_arguments_of_printf_are_filled_in(said):
    form = b"value %g of %s is out of range [%d, %d]"
    message = said(TEXT(form), DOUBLE(42.5), TEXT(b"pressure"), INT(1), INT(9))

    assert message == (3, "cat", "value 42.5 of pressure is out of range [1, 9]")


def test_more_arguments_than_registers_are_filled_in(said):
    form = b" ".join([b"%d"] * 9 + [b"%.1f"] * 10 + [b"%s"])
    given = [INT(-i) for i in range(9)] + [DOUBLE(i / 2) for i in range(10)] + [TEXT(b"end")]
    expected = " ".join([str(-i) for i in range(9)] + [f"{i / 2:.1f}" for i in range(10)] + ["end"])

    assert said(TEXT(form), *given)[2] == expected


@pytest.mark.parametrize(
    ("form", "argument", "text"),
    [
        (b"[%5.2f]", DOUBLE(3.14159), "[ 3.14]"),
        (b"[%-6s]", TEXT(b"ab"), "[ab    ]"),
        (b"[%.3s]", TEXT(b"abcdef"), "[abc]"),
        (b"[%+d]", INT(5), "[+5]"),
        (b"[% d]", INT(5), "[ 5]"),
        (b"[%05d]", INT(42), "[00042]"),
        (b"[%#x]", INT(255), "[0xff]"),
        (b"[%o]", INT(8), "[10]"),
        (b"[%u]", ctypes.c_uint(4_000_000_000), "[4000000000]"),
        (b"[%lld]", ctypes.c_int64(-(2**40)), "[-1099511627776]"),
        (b"[%zu]", ctypes.c_size_t(77), "[77]"),
        (b"[%hhd]", INT(300), "[44]"),
        (b"[%c]", INT(ord("q")), "[q]"),
        (b"[%e]", DOUBLE(1234.5), "[1.234500e+03]"),
        (b"[%g]", DOUBLE(float("inf")), "[inf]"),
        (b"[%i%%]", INT(7), "[7%]"),
        (b"[%s]", TEXT(None), "[(null)]"),
    ],
)
def test_conversions_are_those_of_c(said, form, argument, text):
    assert said(TEXT(form), argument)[2] == text


def test_a_width_may_be_an_argument(said):
    assert said(TEXT(b"[%*d|%-*d]"), INT(4), INT(12), INT(4), INT(12))[2] == "[  12|12  ]"


@pytest.mark.parametrize("text", ["50% of the range", "100 %", "plain", "%", "20% up, 30% off", "größe"])
def test_a_text_that_is_no_format_stays_as_it_is(said, text):
    assert said(TEXT(text.encode()))[2] == text


def test_a_format_without_its_text_does_not_end_the_process(said):
    assert said(TEXT(b"100%% %s broken"), POINTER(0x1234))[2] == "100%% %s broken"


def test_a_pointer_to_nothing_is_told(said):
    assert said(POINTER(0x1234))[2] == "(text at 0x1234 cannot be read)"
    assert said(POINTER(None), category=None) == (3, "", "")


def test_a_long_message_is_cut_with_a_note(said):
    for message in (said(TEXT(b"x" * 2_000_000)), said(TEXT(b"%s"), TEXT(b"x" * 2_000_000))):
        assert message[2] == "x" * 4000 + " ... (cut after 4000 bytes)"


@pytest.mark.parametrize("status", [-7, 99])
def test_a_message_with_a_status_that_fmi_does_not_define_counts_as_an_error_with_its_number(status):
    log = MessageLog()
    log.note("a", status, "", "odd")

    assert log.summary()[0].status == f"status {status}"


@pytest.fixture
def at():
    """Move the run to a tick and a function."""
    with position.using(Position()) as present:
        present.step([("a", 2)], 0.0, 1.0)

        def move(tick=0, function=""):
            present.enter("a", function)
            present.cells[TICK] = tick
            present.cells[PHASE] = 0 if function else MAKING_A_STEP

        yield move


def test_a_failure_shows_the_messages_of_its_call_errors_first(at):
    log = MessageLog()
    at(4)
    log.note("a", 3, "cat", "of the tick before")
    at(5)
    log.note("a", 0, "", "all is well")
    log.note("a", 1, "cat", "careful")
    log.note("a", 3, "cat", "torn")

    assert log.of_call("a") == "[cat] torn; [cat] careful"
    at(6)
    assert log.of_call("a") == ""


def test_of_a_flood_in_one_call_the_errors_stay(at):
    log = MessageLog()
    at(1)
    log.note("a", 3, "", "torn")
    for i in range(10_000):
        log.note("a", 1, "", f"careful {i}")

    assert log.of_call("a").startswith("torn; careful")
    assert log.of_call("a").endswith("... and 9996 more")


def test_warnings_and_errors_are_counted_with_the_time_of_the_first(at):
    log = MessageLog(time_of=lambda tick: 0.5 * tick)
    for tick in range(3, 9):
        at(tick)
        log.note("a", 1, "cat", "careful")
    [said] = log.summary()

    assert (said.fmu, said.status, said.category, said.text) == ("a", "warning", "cat", "careful")
    assert (said.t, said.count) == (1.5, 6)


def test_control_characters_are_shown_not_carried_out(at):
    log = MessageLog()
    log.note("a", 3, "", "\x1b]0;owned\x07\x1b[2J\u202ered")

    assert log.summary()[0].text == "\\x1b]0;owned\\x07\\x1b[2J\\u202ered"


def test_a_message_a_step_needs_no_more_memory(at, tmp_path):
    file = LogFile(tmp_path / "fmu.log", "warning")
    log = MessageLog(time_of=float, file=file)

    def speak(begin, end):
        for tick in range(begin, end):
            at(tick)
            log.note("a", 1, "cat", f"temperature is {tick}")

    speak(0, 2000)
    gc.collect()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    speak(2000, 60_000)
    unit = 1 if sys.platform == "darwin" else 1024

    assert unit * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before) < 5e6
    assert sum(said.count for said in log.summary()) == 60_000
    assert len(log.summary()) < 30


def test_the_log_file_has_the_messages_from_its_level_on_alike_ones_counted(at, tmp_path):
    file = LogFile(tmp_path / "fmu.log", "warning")
    log = MessageLog(time_of=lambda tick: 0.5 * tick, file=file)
    at(1, "fmi2Instantiate")
    log.note("a", 0, "", "not shown")
    for tick in (2, 3, 4):
        at(tick)
        log.note("a", 1, "cat", "careful")
    at(5)
    log.note("a", 3, "cat", "torn")
    file.close()

    assert (tmp_path / "fmu.log").read_text().splitlines() == [
        "t=1 s  a  warning  [cat] careful",
        "    ... and 2 times more",
        "t=2.5 s  a  error  [cat] torn",
    ]


def test_a_log_file_without_messages_is_removed(tmp_path):
    LogFile(tmp_path / "fmu.log", "error").close()

    assert list(tmp_path.iterdir()) == []
