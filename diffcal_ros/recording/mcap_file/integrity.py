# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tell whether an mcap file is whole: its end, and the checksums over all of its bytes."""

from dataclasses import dataclass
from pathlib import Path
import struct
from typing import BinaryIO, Protocol
import zlib

from diffcal_ros.errors import RecordingError
from diffcal_ros.recording.mcap_file.records import MAGIC

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
class Ending:
    """How a file ends.

    Attributes:
        data_end: end of the records with data; None when the end of the file is missing.
        problem: what does not fit, in words; empty where everything does.
        is_summary_sure: whether what stands behind the data has a checksum, which fits.
    """

    data_end: int | None
    problem: str = ''
    is_summary_sure: bool = False

    @property
    def is_whole(self) -> bool:
        """Tell whether the file has its end."""
        return self.data_end is not None


@dataclass(frozen=True)
class _Span:
    """Bytes that a checksum covers; checksum 0 means that none was written."""

    start: int
    end: int
    checksum: int


def check_file(path: Path, content_hash: Hash) -> Ending:
    """Read a file once from end to end: hash it and compare its checksums.

    Args:
        path: the file.
        content_hash: takes all bytes.

    Raises:
        RecordingError: when the file is empty, no mcap, or cannot be read.
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
            problem = ''
            spans: tuple[_Span, ...] = ()
            try:
                spans = _spans(stream)
            except ValueError as error:
                problem = str(error)
            wrong = _wrong_spans(stream, spans, content_hash)
    except OSError as error:
        raise RecordingError(
            f'{path} cannot be read ({error.strerror or error}): check the disk, and that you '
            'may read the file'
        ) from error
    if wrong:
        problem = f'bytes {wrong[0].start} to {wrong[0].end} fail their checksum'
    if not spans:
        # A footer that misleads does not tell where the data ends.
        return Ending(path.stat().st_size if problem else None, problem)
    data, summary = spans
    return Ending(data.end, problem, summary.checksum != 0 and summary not in wrong)


def corrupt(path: Path, reason: str) -> RecordingError:
    """Make the error for bytes that have changed."""
    return RecordingError(
        f'{path} is corrupt, {reason}: copy it again from where it was recorded, or add '
        '--allow-truncated to use what is whole'
    )


def _spans(stream: BinaryIO) -> tuple[_Span, ...]:
    """Find what the checksums at the end cover; nothing when the file was cut off.

    Raises:
        ValueError: when the end misleads.
    """
    footer = stream.seek(0, 2) - len(MAGIC) - _FOOTER.size
    if footer < len(MAGIC):
        return ()
    stream.seek(footer)
    *head, summary, _, summary_checksum = _FOOTER.unpack(stream.read(_FOOTER.size))
    if stream.read() != MAGIC or tuple(head) != _FOOTER_HEAD:
        return ()
    data_end = (summary or footer) - _DATA_END.size
    if not len(MAGIC) <= data_end <= footer - _DATA_END.size:
        raise ValueError('its footer points outside the file')
    stream.seek(data_end)
    *head, data_checksum = _DATA_END.unpack(stream.read(_DATA_END.size))
    if tuple(head) != _DATA_END_HEAD:
        raise ValueError('its footer does not point to the end of the data')
    # The summary's checksum covers the footer too, but for itself.
    last = footer + _FOOTER.size - _CHECKSUM_SIZE
    return (
        _Span(0, data_end, data_checksum),
        _Span(summary or footer, last, summary_checksum),
    )


def _wrong_spans(stream: BinaryIO, spans: tuple[_Span, ...], content_hash: Hash) -> list[_Span]:
    """Read everything; return the spans that fail their checksums."""
    checksums = [0] * len(spans)
    position = stream.seek(0)
    while block := stream.read(_BLOCK):
        content_hash.update(block)
        for number, span in enumerate(spans):
            inside = block[max(span.start - position, 0) : max(span.end - position, 0)]
            checksums[number] = zlib.crc32(inside, checksums[number])
        position += len(block)
    return [
        span
        for span, checksum in zip(spans, checksums, strict=True)
        if span.checksum not in (0, checksum)
    ]
