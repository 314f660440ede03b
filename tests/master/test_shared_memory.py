"""Memory shared with forked processes, and what one of them does not get."""

import ctypes
import gc
import mmap
import sys

import pytest

from master.process.child import done_apart
from master.process.memory import shared_memory

pytestmark = pytest.mark.skipif(not sys.platform.startswith("linux"), reason="no process is forked here")

N_BYTES = 2**20


def test_a_process_is_forked_while_memory_that_it_does_not_get_is_alive():
    memory = shared_memory(N_BYTES)
    memory.share_no_further()

    assert done_apart(lambda: 7) == 7


def test_a_forked_process_keeps_what_it_has_where_the_other_one_has_memory_of_its_own():
    memories = [shared_memory(N_BYTES)]
    first = ctypes.c_char.from_buffer(memories[0])
    address = ctypes.addressof(first)
    del first
    memories[0].share_no_further()

    def work():
        library = ctypes.CDLL(None)
        library.mmap.restype = ctypes.c_void_p
        places = [ctypes.c_void_p(address), ctypes.c_size_t(N_BYTES)]
        access = mmap.PROT_READ | mmap.PROT_WRITE
        given = library.mmap(*places, access, mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS, -1, ctypes.c_long(0))
        ctypes.memset(given, 7, N_BYTES)
        memories.clear()
        gc.collect()
        return given == address, ctypes.string_at(given, N_BYTES) == b"\7" * N_BYTES

    assert done_apart(work) == (True, True)
