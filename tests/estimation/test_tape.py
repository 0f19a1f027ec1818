import tracemalloc

import numpy as np
import pytest

from belt_ros.estimation.tape import Record, Tape


@pytest.mark.parametrize("in_memory", [1, 1_000_000])
def test_records_come_back_the_last_first(in_memory: int) -> None:
    random = np.random.default_rng(0)
    written = [
        Record(kind, 10**18 + kind, random.standard_normal(size))
        for kind, size in enumerate([3, 0, 1000, 7])
    ]
    tape = Tape(in_memory)
    for _ in range(2):  # reading takes nothing off, and does not disturb writing
        for record in written:
            tape.append(record)
        found = list(tape.backwards())
    tape.close()
    assert len(found) == 8
    for record, expected in zip(found, (written * 2)[::-1], strict=True):
        assert record[:2] == expected[:2]
        np.testing.assert_array_equal(record.values, expected.values)


def test_an_empty_tape_has_no_records() -> None:
    tape = Tape(100)
    assert list(tape.backwards()) == []
    tape.close()


def test_a_long_tape_does_not_stay_in_memory() -> None:
    tape = Tape(100_000)
    tracemalloc.start()
    for stamp in range(2000):
        tape.append(Record(0, stamp, np.full(1000, float(stamp))))
    total = sum(float(record.values[-1]) for record in tape.backwards())
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    tape.close()
    assert total == 2000 * 1999 / 2
    assert most < 500_000  # of 16 MB
