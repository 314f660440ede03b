"""
What the kernel refuses to a sandboxed process: network, writing outside one folder, other processes.

Landlock keeps all that opens, makes, removes or truncates files within the folder; a filter of system calls
(seccomp) refuses sockets, changes of owner and mode, signals to others and what would lead out of both.
Neither needs rights, and neither can be taken back. Reading is not restricted.
"""

from __future__ import annotations

import ctypes
import os
import platform
import struct
import sys
from contextlib import suppress

LEAST_LANDLOCK = 3  # Linux 6.2: the first that keeps files from being truncated

_CREATE_RULESET, _ADD_RULE, _RESTRICT_SELF = 444, 445, 446
_GET_VERSION = 1
_PATH_BENEATH = 1
_WRITE_FILE = 1 << 1
_FIRST_CHANGE, _REFER, _TRUNCATE, _DEVICE = 4, 13, 14, 15  # bits of rights, see landlock(7)
_CHANGES = sum(1 << bit for bit in range(_FIRST_CHANGE, _TRUNCATE + 1)) | _WRITE_FILE
_NETWORK = 0b11  # TCP: bind and connect, from version 4 on
_SCOPES = 0b11  # abstract sockets and signals, from version 6 on
_HARMLESS = ("/dev/null", "/dev/zero", "/dev/full")

_SET_SECCOMP, _GET_SECCOMP, _NO_NEW_RIGHTS, _FILTER = 22, 21, 38, 2
_LOAD, _EQUAL, _AT_LEAST, _RETURN = 0x20, 0x15, 0x35, 0x06
_ALLOW, _REFUSE, _KILL = 0x7FFF0000, 0x00050001, 0x80000000
_NUMBER_AT, _ARCHITECTURE_AT, _ARGUMENTS_AT = 0, 4, 16
_OTHER_NUMBERS = 0x40000000  # x32
_TYPES_FOR_OTHERS = (0x5412, 0x541C)  # TIOCSTI, TIOCLINUX: keystrokes for the terminal

_ARCHITECTURES = {"x86_64": 0xC000003E, "aarch64": 0xC00000B7}

# Numbers of system calls: on x86_64, then on aarch64; None where there is none.
_REFUSED: dict[str, tuple[int | None, int | None]] = {
    "socket": (41, 198),
    "connect": (42, 203),
    "bind": (49, 200),
    "ptrace": (101, 117),
    "process_vm_readv": (310, 270),
    "process_vm_writev": (311, 271),
    "pidfd_send_signal": (424, 424),
    "pidfd_getfd": (438, 438),
    "tkill": (200, 130),
    "rt_sigqueueinfo": (129, 138),
    "rt_tgsigqueueinfo": (297, 240),
    "io_uring_setup": (425, 425),
    "bpf": (321, 280),
    "perf_event_open": (298, 241),
    "userfaultfd": (323, 282),
    "add_key": (248, 217),
    "request_key": (249, 218),
    "keyctl": (250, 219),
    "mount": (165, 40),
    "umount2": (166, 39),
    "move_mount": (429, 429),
    "open_tree": (428, 428),
    "fsopen": (430, 430),
    "pivot_root": (155, 41),
    "chroot": (161, 51),
    "unshare": (272, 97),
    "setns": (308, 268),
    "open_by_handle_at": (304, 265),
    "chmod": (90, None),
    "fchmod": (91, 52),
    "fchmodat": (268, 53),
    "fchmodat2": (452, 452),
    "chown": (92, None),
    "fchown": (93, 55),
    "lchown": (94, None),
    "fchownat": (260, 54),
    "utime": (132, None),
    "utimes": (235, None),
    "futimesat": (261, None),
    "utimensat": (280, 88),
    "setxattr": (188, 5),
    "lsetxattr": (189, 6),
    "fsetxattr": (190, 7),
    "removexattr": (197, 14),
    "lremovexattr": (198, 15),
    "fremovexattr": (199, 16),
    "shmget": (29, 194),
    "shmat": (30, 196),
    "msgget": (68, 186),
    "semget": (64, 190),
    "mq_open": (240, 180),
    "setpriority": (141, 140),
    "acct": (163, 89),
    "swapon": (167, 224),
    "reboot": (169, 142),
    "kexec_load": (246, 104),
    "init_module": (175, 105),
    "finit_module": (313, 273),
}
_TO_ITSELF_ALONE = {"kill": (62, 129), "tgkill": (234, 131)}
_OF_ITSELF_ALONE = {"prlimit64": (302, 261), "sched_setaffinity": (203, 122)}
_IOCTL = (16, 29)


def what_is_missing() -> str:
    """Say what this system lacks for a sandbox, empty if it has all."""
    if not sys.platform.startswith("linux") or platform.machine() not in _ARCHITECTURES:
        return "no sandbox on this system, which needs Linux on x86_64 or aarch64"
    version = _landlock_version()
    if version < LEAST_LANDLOCK:
        return (
            f"no sandbox on this system, got Landlock {max(version, 0)} of the kernel, which has to be"
            f" at least {LEAST_LANDLOCK} (Linux 6.2)"
        )
    if ctypes.CDLL(None).prctl(_GET_SECCOMP, 0, 0, 0, 0) < 0:
        return "no sandbox on this system, whose kernel filters no system calls (seccomp)"
    return ""


def shut_in(folder: str) -> None:
    """
    Let this process, and all that it starts, write within a folder only, and reach nobody.

    What it prints goes nowhere: bytes to a terminal may be commands to it.

    Raises:
        OSError: If the kernel refuses; the process is not shut in then.
    """
    nowhere = os.open(os.devnull, os.O_RDWR)
    for descriptor in range(3):
        os.dup2(nowhere, descriptor)
    os.close(nowhere)
    _checked(ctypes.CDLL(None, use_errno=True).prctl(_NO_NEW_RIGHTS, 1, 0, 0, 0))
    _keep_files_within(folder)
    _filter_calls()


def _landlock_version() -> int:
    return _system_call(_CREATE_RULESET, None, 0, _GET_VERSION)


def _keep_files_within(folder: str) -> None:
    version = _landlock_version()
    rights = _CHANGES | (1 << _DEVICE if version >= 5 else 0)
    parts = [rights, _NETWORK if version >= 4 else 0, _SCOPES if version >= 6 else 0]
    n = 3 if version >= 6 else 2 if version >= 4 else 1
    attributes = struct.pack(f"<{n}Q", *parts[:n])
    ruleset = _checked(_system_call(_CREATE_RULESET, attributes, len(attributes), 0))
    for path, allowed in [(folder, rights), *((device, _WRITE_FILE) for device in _HARMLESS)]:
        with suppress(FileNotFoundError):
            place = os.open(path, os.O_PATH | os.O_CLOEXEC)
            rule = struct.pack("<Qi", allowed, place)
            _checked(_system_call(_ADD_RULE, ruleset, _PATH_BENEATH, rule, 0))
            os.close(place)
    _checked(_system_call(_RESTRICT_SELF, ruleset, 0))
    os.close(ruleset)


def _filter_calls() -> None:
    program = _filter(platform.machine(), os.getpid())
    code = ctypes.create_string_buffer(program, len(program))
    header = struct.pack("<HxxxxxxQ", len(program) // 8, ctypes.addressof(code))
    prctl = ctypes.CDLL(None, use_errno=True).prctl
    _checked(prctl(_SET_SECCOMP, _FILTER, ctypes.c_char_p(header), 0, 0))


def _filter(machine: str, process: int) -> bytes:
    """Program of the filter: refused calls answer with EPERM, calls of other kinds end the process."""
    column = 0 if machine == "x86_64" else 1
    code = [
        _instruction(_LOAD, _ARCHITECTURE_AT),
        _instruction(_EQUAL, _ARCHITECTURES[machine], 1, 0),
        _instruction(_RETURN, _KILL),
        _instruction(_LOAD, _NUMBER_AT),
        _instruction(_AT_LEAST, _OTHER_NUMBERS, 0, 1),
        _instruction(_RETURN, _KILL),
    ]
    for numbers in _REFUSED.values():
        if numbers[column] is not None:
            code += [_instruction(_EQUAL, numbers[column] or 0, 0, 1), _instruction(_RETURN, _REFUSE)]
    for numbers in _TO_ITSELF_ALONE.values():
        code += _unless(numbers[column], 0, [process])
    for numbers in _OF_ITSELF_ALONE.values():
        code += _unless(numbers[column], 0, [0, process])
    code += [
        _instruction(_EQUAL, _IOCTL[column], 0, 2 + 2 * len(_TYPES_FOR_OTHERS)),
        _instruction(_LOAD, _ARGUMENTS_AT + 8),
    ]
    for command in _TYPES_FOR_OTHERS:
        code += [_instruction(_EQUAL, command, 0, 1), _instruction(_RETURN, _REFUSE)]
    code += [_instruction(_RETURN, _ALLOW), _instruction(_RETURN, _ALLOW)]
    return b"".join(code)


def _unless(number: int, argument: int, values: list[int]) -> list[bytes]:
    """Refuse a call unless one of its arguments has one of some values."""
    n = len(values)
    code = [_instruction(_EQUAL, number, 0, n + 3), _instruction(_LOAD, _ARGUMENTS_AT + 8 * argument)]
    code += [_instruction(_EQUAL, value, n - i, 0) for i, value in enumerate(values)]
    return [*code, _instruction(_RETURN, _REFUSE), _instruction(_RETURN, _ALLOW)]


def _instruction(code: int, value: int, if_true: int = 0, if_false: int = 0) -> bytes:
    return struct.pack("<HBBI", code, if_true, if_false, value)


def _system_call(number: int, *arguments: int | bytes | None) -> int:
    function = ctypes.CDLL(None, use_errno=True).syscall
    function.restype = ctypes.c_long
    given = [ctypes.c_long(a) if isinstance(a, int) else ctypes.c_char_p(a) for a in arguments]
    return int(function(ctypes.c_long(number), *given))


def _checked(result: int) -> int:
    if result < 0:
        number = ctypes.get_errno()
        raise OSError(number, os.strerror(number))
    return result
