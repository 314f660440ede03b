"""The logger's register of instances."""

import gc
import tracemalloc

from master.fmi import logger


def test_instances_that_have_ended_leave_nothing_in_the_register():
    """10 000 of them would keep 0.3 MB if their numbers alone were kept."""

    def begin_and_end(number):
        for _ in range(number):
            logger.remove(logger.add(lambda status, category, text: None))

    begin_and_end(100)
    gc.collect()
    tracemalloc.start()
    try:
        before = tracemalloc.get_traced_memory()[0]
        begin_and_end(10_000)
        gc.collect()
        kept = tracemalloc.get_traced_memory()[0] - before
    finally:
        tracemalloc.stop()

    assert kept < 10_000
