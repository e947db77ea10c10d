# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The metadata.yaml of a rosbag2 directory, version 9 (ROS 2 Jazzy)."""

from dataclasses import dataclass
from typing import Any

import yaml

_VERSION = 9
# What rmw writes for "no limit".
_FOREVER = {'sec': 9223372036, 'nsec': 854775807}


@dataclass(frozen=True)
class BagTopic:
    """A topic of a bag.

    Attributes:
        name: absolute.
        type_name: for example sensor_msgs/msg/Image.
        type_hash: RIHS01.
        is_latched: offered as transient local, so that late subscribers get it.
    """

    name: str
    type_name: str
    type_hash: str
    is_latched: bool


def qos_profiles(topic: BagTopic) -> list[dict[str, Any]]:
    """Return the quality of service that a topic was offered with."""
    return [
        {
            'history': 'keep_last',
            'depth': 1 if topic.is_latched else 5,
            'reliability': 'reliable',
            'durability': 'transient_local' if topic.is_latched else 'volatile',
            'deadline': dict(_FOREVER),
            'lifespan': dict(_FOREVER),
            'liveliness': 'automatic',
            'liveliness_lease_duration': dict(_FOREVER),
            'avoid_ros_namespace_conventions': False,
        }
    ]


def bag_metadata(
    *,
    file_name: str,
    counts: dict[BagTopic, int],
    first_ns: int,
    last_ns: int,
) -> str:
    """Write the metadata of a bag of one mcap file.

    Args:
        file_name: of the mcap file beside it.
        counts: messages of each topic.
        first_ns: earliest message [ns].
        last_ns: latest message [ns].
    """
    total = sum(counts.values())
    topics = [
        {
            'topic_metadata': {
                'name': topic.name,
                'type': topic.type_name,
                'serialization_format': 'cdr',
                'offered_qos_profiles': qos_profiles(topic),
                'type_description_hash': topic.type_hash,
            },
            'message_count': count,
        }
        for topic, count in counts.items()
    ]
    information = {
        'version': _VERSION,
        'storage_identifier': 'mcap',
        **_span(first_ns, last_ns, total),
        'topics_with_message_count': topics,
        'compression_format': '',
        'compression_mode': '',
        'relative_file_paths': [file_name],
        'files': [{'path': file_name, **_span(first_ns, last_ns, total)}],
        'custom_data': None,
        'ros_distro': 'jazzy',
    }
    return as_yaml({'rosbag2_bagfile_information': information})


def as_yaml(content: Any) -> str:
    """Write YAML, keys in the given order."""
    return str(yaml.safe_dump(content, sort_keys=False))


def _span(first_ns: int, last_ns: int, count: int) -> dict[str, Any]:
    # Made anew for each use: YAML would write a shared one as a reference.
    return {
        'duration': {'nanoseconds': last_ns - first_ns},
        'starting_time': {'nanoseconds_since_epoch': first_ns},
        'message_count': count,
    }
