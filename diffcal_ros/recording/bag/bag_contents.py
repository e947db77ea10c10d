# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the files of a bag hold together, and what of it is lost."""

from collections import Counter
from pathlib import Path

from diffcal_ros.errors import RecordingError
from diffcal_ros.plain_text import listed, plain
from diffcal_ros.recording.bag.bag_files import BagFiles
from diffcal_ros.recording.mcap_file.damage import Rescued, UNKNOWN_TOPIC
from diffcal_ros.recording.mcap_file.index import Entry, FileIndex

_CURE = (
    'copy the whole bag again, add --allow-truncated to use what is there, or remove '
    'metadata.yaml to read the files as they are'
)


class BagContents:
    """Messages of all files, by topic, and an account of those that are not there.

    Attributes:
        types: message type of each topic that has messages.
        entries: messages of each topic, in the order of recording once all is finished.
        lost: messages that cannot be read, by topic, as far as the recording tells.
        notes: what is odd, in sentences.
        saved_count: messages that can be read of a damaged recording; None for a whole one.
    """

    def __init__(self, bag: BagFiles) -> None:
        """Start with nothing.

        Args:
            bag: the files that are to come.
        """
        self._bag = bag
        self.types: dict[str, str] = {}
        self.entries: dict[str, list[Entry]] = {}
        self.lost: Counter[str] = Counter()
        self.notes = bag.notes
        self.saved_count: int | None = None
        self._problems: list[str] = []
        self._is_counted = True

    def add(self, index: FileIndex) -> None:
        """Take in the messages of a file."""
        for channel_id, entries in index.entries.items():
            channel = index.channels[channel_id]
            schema = index.schemas.get(channel.schema_id)
            if entries:
                self.types.setdefault(channel.topic, '' if schema is None else schema.name)
                self.entries.setdefault(channel.topic, []).extend(entries)

    def add_rescued(self, file: Path, rescued: Rescued) -> None:
        """Take in what is left of a file."""
        self.add(rescued.index)
        self.lost += rescued.lost
        if rescued.problem:
            self._problems.append(f'{file} {rescued.problem}')
            self._is_counted &= rescued.is_counted

    def finish(self, *, is_strict: bool) -> None:
        """Put messages in order and compare them with what metadata.yaml counts.

        Args:
            is_strict: whether a difference is an error.

        Raises:
            RecordingError: when files or messages are missing, or nothing is left.
        """
        for entries in self.entries.values():
            # Publishers of one topic may be recorded in chunks of their own.
            entries.sort(key=lambda entry: (entry.file, entry.log_time_ns))
        self._compare_files(is_strict=is_strict)
        self._compare_counts(is_strict=is_strict)
        if not self._problems:
            return
        self.saved_count = sum(len(entries) for entries in self.entries.values())
        problems = '; '.join(self._problems)
        if not self.saved_count:
            raise RecordingError(
                f'{problems}, and no message stands before the cut or beside the damage: record '
                'again'
            )
        self.notes = (*self.notes, f'{problems}: {self.account()}')

    def account(self) -> str:
        """Say how many messages were read, and which are lost."""
        read = f'{self.saved_count} messages can be read'
        parts = [
            f'{count} of {count + len(self.entries.get(topic, []))} on {plain(topic)}'
            for topic, count in sorted(self.lost.items())
        ]
        if self._is_counted:
            return f'{read}, lost are {listed(parts) or "none"}'
        known = f'; known to be lost are {listed(parts)}' if parts else ''
        return f'{read}{known}; how many are lost in all is not known'

    def _compare_files(self, *, is_strict: bool) -> None:
        missing = listed(self._bag.missing)
        if not missing:
            return
        if is_strict:
            raise RecordingError(
                f'{self._bag.files[0].parent} lacks {missing}, which its metadata.yaml lists: '
                f'{_CURE}'
            )
        self._problems.append(f'{missing}, which metadata.yaml lists, is not there')
        self._is_counted &= self._bag.counts is not None

    def _compare_counts(self, *, is_strict: bool) -> None:
        told = self._bag.counts
        if told is None:
            return
        found = {topic: len(entries) for topic, entries in self.entries.items()}
        for topic in sorted(told.keys() | found.keys()):
            have, wanted = found.get(topic, 0), told.get(topic, 0)
            if have == wanted:
                continue
            difference = (
                f'metadata.yaml counts {wanted} messages on {plain(topic)} and the files hold '
                f'{have}'
            )
            if is_strict:
                raise RecordingError(f'{self._bag.files[0].parent}: {difference}: {_CURE}')
            if have > wanted:
                self._problems.append(difference)
                continue
            if not self._problems:
                self._problems.append('metadata.yaml counts more messages than there are')
            self.lost[topic] = max(self.lost[topic], wanted - have)
        # Now everything is counted, by topic, whatever the files themselves tell.
        self._is_counted = True
        del self.lost[UNKNOWN_TOPIC]
