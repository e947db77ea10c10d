# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Step over the records of a damaged or cut-off mcap file, and find where they go on."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
import re

from diffcal_ros.recording.mcap_file.records import (
    Bytes,
    IN_DATA,
    message_head,
    MisfitError,
    PRIVATE,
    Record,
    record_at,
)
from mcap.opcode import Opcode

# A known opcode, and a length of less than 4 GB.
_LOOKS_LIKE_A_HEAD = re.compile(rb'[\x03-\x07\x09\x0c\x0f](?=.{4}\x00{4})', re.DOTALL)
_DAY = 86_400_000_000_000  # [ns]
# So many records in a row are no accident, whatever they are.
_IN_A_ROW = 3
# Shorter, they hold nothing and may be zeros.
_LEAST_LENGTH: dict[int, int] = {Opcode.CHUNK: 40, Opcode.MESSAGE_INDEX: 6}


@dataclass(frozen=True)
class Gap:
    """Bytes that hold no record.

    Attributes:
        start: of the first.
        end: behind the last.
    """

    start: int
    end: int


class Rescue:
    """Steps over the records that are left of a file."""

    def __init__(self, data: Bytes, start: int, channels: Iterable[int] = ()) -> None:
        """Take the bytes of a file.

        Args:
            data: of the whole file.
            start: of the first record.
            channels: numbers of those that are known beforehand.
        """
        self._data = data
        self._start = start
        self._channels = set(channels)
        self._days: set[int] = set()

    def steps(self) -> Iterator[Record | Gap]:
        """Return records and gaps in turn, up to the end of the data or of the file."""
        place = self._start
        last: Record | None = None  # Held back: only what follows shows that it is right.
        while place < len(self._data):
            try:
                found = record_at(self._data, place, len(self._data), IN_DATA)
            except MisfitError:
                after = self._after(place, last)
                if last is not None and after >= place:
                    yield last
                yield Gap(place, after)
                last, place = None, after
                continue
            if last is not None:
                yield last
            if found.opcode == Opcode.DATA_END:
                return
            self._note(found)
            last, place = found, found.end
        if last is not None:
            yield last

    def _after(self, place: int, last: Record | None) -> int:
        """Return where records go on after one that does not fit.

        The one before may have claimed to be longer than it is: then that is inside of it.
        """
        if last is None or not (last.opcode == Opcode.MESSAGE or last.opcode >= PRIVATE):
            return self._next_record(place + 1)
        return self._next_record(last.start + 1)

    def _note(self, record: Record) -> None:
        if record.opcode == Opcode.MESSAGE:
            head = message_head(self._data, record)
            self._channels.add(head.channel_id)
            self._days.add(head.log_time_ns // _DAY)

    def _next_record(self, place: int) -> int:
        """Return where records go on, or the end of the file."""
        for match in _LOOKS_LIKE_A_HEAD.finditer(self._data, place):
            if self._is_beginning(match.start()):
                return match.start()
        return len(self._data)

    def _is_beginning(self, place: int) -> bool:
        """Tell whether records go on here: one that is unmistakable, or some in a row."""
        end = len(self._data)
        for _ in range(_IN_A_ROW):
            try:
                record = record_at(self._data, place, end, IN_DATA)
            except MisfitError:
                return False
            if record.opcode == Opcode.MESSAGE and not self._is_likely(record):
                return False
            if self._is_unmistakable(record):
                return True
            place = record.end
            if place == end:
                return True
        return True

    def _is_unmistakable(self, record: Record) -> bool:
        if record.opcode == Opcode.MESSAGE:
            return bool(self._days)
        least = _LEAST_LENGTH.get(record.opcode)
        return least is not None and record.end - record.content > least

    def _is_likely(self, record: Record) -> bool:
        """Tell whether a message belongs to a known channel and to a day near another's."""
        head = message_head(self._data, record)
        if self._channels and head.channel_id not in self._channels:
            return False
        day = head.log_time_ns // _DAY
        return not self._days or bool(self._days & {day - 1, day, day + 1})
