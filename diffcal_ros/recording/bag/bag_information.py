# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the metadata.yaml of a rosbag2 directory tells, with nothing in it taken on trust."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diffcal_ros.plain_text import plain
import yaml

# A bag of a thousand topics has 2 MB.
_LARGEST = 8 * 2**20
_DEEPEST = 50
_Loader: Any = getattr(yaml, 'CSafeLoader', yaml.SafeLoader)


@dataclass(frozen=True)
class BagInformation:
    """What matters of a metadata.yaml.

    Attributes:
        storage: for example mcap.
        compression: how whole files or messages are compressed; empty or none: they are not.
        files: names, in the order of recording.
        counts: messages of each topic, None where they are not counted.
    """

    storage: str
    compression: str
    files: tuple[str, ...]
    counts: dict[str, int] | None


def read_information(file: Path) -> tuple[BagInformation | None, tuple[str, ...]]:
    """Read a metadata.yaml.

    Returns:
        What it tells, None when it is missing or damaged; and a note in the latter case.
    """
    if not file.exists():
        return None, ()
    try:
        return _information(_content(file)), ()
    except (OSError, ValueError, TypeError, LookupError, AttributeError, yaml.YAMLError) as error:
        reason = plain(str(error).replace('\n', ' '), 120)
        return None, (f'{file.name} cannot be read ({reason}): the .mcap files beside it are',)


def _content(file: Path) -> Any:
    """Parse a file whose size and depth are bounded."""
    if not file.is_file() or file.stat().st_size > _LARGEST:
        raise ValueError(f'it is no regular file of {_LARGEST // 2**20} MB at most')
    text = file.read_text(encoding='utf-8')
    depth = 0
    for event in yaml.parse(text, Loader=_Loader):
        if isinstance(event, yaml.AliasEvent):
            # Few of them make gigabytes, and no recorder writes any.
            raise ValueError('it holds references')
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > _DEEPEST:
            raise ValueError(f'it is nested more than {_DEEPEST} deep')
    return yaml.load(text, Loader=_Loader)


def _information(content: Any) -> BagInformation:
    told = content['rosbag2_bagfile_information']
    names = told.get('relative_file_paths') or []
    return BagInformation(
        storage=plain(str(told.get('storage_identifier', 'mcap'))),
        compression=plain(str(told.get('compression_mode') or '').lower()),
        files=tuple(Path(str(name)).name for name in names),
        counts=_counts(told.get('topics_with_message_count')),
    )


def _counts(topics: Any) -> dict[str, int] | None:
    if not isinstance(topics, list) or not topics:
        return None
    counts: Counter[str] = Counter()
    for topic in topics:
        counts[str(topic['topic_metadata']['name'])] += int(topic['message_count'])
    return dict(counts)
