"""Records written one after another and read back from the last to the first.

Small tapes stay in memory, long ones go to a temporary file without a name.
"""

import os
import struct
import tempfile
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

_Floats = NDArray[np.float64]
_LABEL = struct.Struct("<qqq")  # kind, stamp, number of values; behind the values


class Record(NamedTuple):
    """Values of one kind, with a stamp [ns]."""

    kind: int
    stamp_ns: int
    values: _Floats  # (count,)


class Tape:
    """A stack of records that does not grow in memory.

    Parameters
    ----------
    in_memory : int
        Bytes up to which no file is made.
    """

    def __init__(self, in_memory: int) -> None:
        self._file = tempfile.SpooledTemporaryFile(max_size=in_memory)  # noqa: SIM115 - closed below
        self._end = 0

    def append(self, record: Record) -> None:
        """Write `record` at the end.

        Raises
        ------
        OSError
            If the disk is full.
        """
        data = record.values.astype("<f8").tobytes()
        self._file.seek(self._end)
        self._file.write(data + _LABEL.pack(record.kind, record.stamp_ns, len(record.values)))
        self._end += len(data) + _LABEL.size

    def backwards(self) -> Iterator[Record]:
        """Yield all records, the last first."""
        at = self._end
        while at > 0:
            self._file.seek(at - _LABEL.size)
            kind, stamp_ns, count = _LABEL.unpack(self._file.read(_LABEL.size))
            at -= _LABEL.size + 8 * count
            self._file.seek(at, os.SEEK_SET)
            values = np.frombuffer(self._file.read(8 * count), dtype="<f8").astype(np.float64)
            yield Record(kind, stamp_ns, values)

    def close(self) -> None:
        """Remove the file."""
        self._file.close()
