# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read and move the stamp of a serialised message without decoding the rest of it."""

import struct

_SECOND = 1_000_000_000  # [ns]
# Four bytes say how the message is encoded, the second one its byte order; a std_msgs/Header
# begins with the stamp.
_ENCAPSULATION = 4
_END = _ENCAPSULATION + 8


def read_stamp(data: bytes) -> int:
    """Return the stamp [ns] of a CDR message that begins with a std_msgs/Header.

    Raises:
        ValueError: when the message is too short to hold one.
    """
    seconds, nanoseconds = struct.unpack_from(_layout(data), data, _ENCAPSULATION)
    return int(seconds) * _SECOND + int(nanoseconds)


def move_stamp(data: bytes, shift_ns: int) -> bytes:
    """Return the message with its stamp moved by a time [ns].

    Raises:
        ValueError: when the message is too short to hold a stamp.
    """
    if shift_ns == 0:
        return data
    stamp = struct.pack(_layout(data), *divmod(read_stamp(data) + shift_ns, _SECOND))
    return b''.join((data[:_ENCAPSULATION], stamp, memoryview(data)[_END:]))


def _layout(data: bytes) -> str:
    if len(data) < _END:
        raise ValueError(f'a message of {len(data)} bytes holds no header')
    return '<iI' if data[1] & 1 else '>iI'
