# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tell whether an mcap file is whole: its end, and the checksums over all of its bytes."""

from dataclasses import dataclass
from pathlib import Path
import struct
from typing import BinaryIO, Protocol
import zlib

from diffcal_ros.errors import RecordingError

MAGIC = b'\x89MCAP0\r\n'
# A record is one byte of opcode, eight of length, and the content.
RECORD_HEAD = struct.Struct('<BQ')
_FOOTER = struct.Struct('<BQQQI')  # Head, start of the summary, of its offsets, checksum.
_FOOTER_HEAD = (2, 20)
_DATA_END = struct.Struct('<BQI')  # Head, checksum.
_DATA_END_HEAD = (15, 4)
_CHECKSUM_SIZE = 4
_BLOCK = 1 << 20


class Hash(Protocol):
    """What hashlib's objects have in common."""

    def update(self, data: bytes, /) -> None:
        """Take more bytes."""


@dataclass(frozen=True)
class _Span:
    """Bytes that a checksum covers; checksum 0 means that none was written."""

    start: int
    end: int
    checksum: int


def check_file(path: Path, content_hash: Hash) -> bool:
    """Read a file once from end to end: hash it and check its checksums.

    Args:
        path: the file.
        content_hash: takes all bytes.

    Returns:
        True for a whole file, False when its end is missing.

    Raises:
        RecordingError: when the file is empty, no mcap, or its bytes have changed.
    """
    try:
        with path.open('rb') as stream:
            start = stream.read(len(MAGIC))
            if not start:
                raise RecordingError(
                    f'{path} is empty: nothing was recorded, or the copy failed; record again'
                )
            if start != MAGIC[: len(start)]:
                raise RecordingError(
                    f'{path} is no mcap file, it starts otherwise: give a rosbag2 recording'
                )
            spans = _spans(path, stream)
            _check_spans(path, stream, spans or (), content_hash)
    except OSError as error:
        raise RecordingError(
            f'{path} cannot be read ({error.strerror or error}): check the disk, and that you '
            'may read the file'
        ) from error
    return spans is not None


def corrupt(path: Path, reason: str) -> RecordingError:
    """Make the error for bytes that have changed."""
    return RecordingError(
        f'{path} is corrupt, {reason}: copy it again from where it was recorded, or record again'
    )


def _spans(path: Path, stream: BinaryIO) -> tuple[_Span, ...] | None:
    """Find what the checksums at the end cover; None when the file was cut off."""
    footer = stream.seek(0, 2) - len(MAGIC) - _FOOTER.size
    if footer < len(MAGIC):
        return None
    stream.seek(footer)
    *head, summary, _, summary_checksum = _FOOTER.unpack(stream.read(_FOOTER.size))
    if stream.read() != MAGIC or tuple(head) != _FOOTER_HEAD:
        return None
    data_end = (summary or footer) - _DATA_END.size
    if not len(MAGIC) <= data_end <= footer - _DATA_END.size:
        raise corrupt(path, 'its footer points outside the file')
    stream.seek(data_end)
    *head, data_checksum = _DATA_END.unpack(stream.read(_DATA_END.size))
    if tuple(head) != _DATA_END_HEAD:
        raise corrupt(path, 'its footer does not point to the end of the data')
    # The summary's checksum covers the footer too, but for itself.
    last = footer + _FOOTER.size - _CHECKSUM_SIZE
    return (
        _Span(0, data_end, data_checksum),
        _Span(summary or footer, last, summary_checksum),
    )


def _check_spans(
    path: Path, stream: BinaryIO, spans: tuple[_Span, ...], content_hash: Hash
) -> None:
    checksums = [0] * len(spans)
    position = stream.seek(0)
    while block := stream.read(_BLOCK):
        content_hash.update(block)
        for number, span in enumerate(spans):
            inside = block[max(span.start - position, 0) : max(span.end - position, 0)]
            checksums[number] = zlib.crc32(inside, checksums[number])
        position += len(block)
    for span, checksum in zip(spans, checksums, strict=True):
        if span.checksum not in (0, checksum):
            raise corrupt(path, f'bytes {span.start} to {span.end} fail their checksum')
