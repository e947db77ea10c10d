# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Qualities of service: what is offered, and what to ask of publishers that offer something."""

from collections.abc import Sequence

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

# Best-effort images larger than the shared-memory segment lose fragments; reliable ones arrive.
IMAGES = QoSProfile(depth=5, reliability=ReliabilityPolicy.RELIABLE)
# What somebody who comes late should still see.
LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
LATCHED_IMAGES = QoSProfile(
    depth=5,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)
VALUES = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)


def strictest_offered(
    offers: Sequence[TopicEndpointInfo], depth: int, *, is_latched: bool
) -> QoSProfile:
    """Return the most that every publisher of a topic grants.

    Args:
        offers: the publishers.
        depth: messages that are kept.
        is_latched: while there is no publisher, ask for what it sent before too; whoever offers
            less makes an event of it.
    """
    are_reliable = all(
        offer.qos_profile.reliability is not ReliabilityPolicy.BEST_EFFORT for offer in offers
    )
    are_latched = all(
        offer.qos_profile.durability is DurabilityPolicy.TRANSIENT_LOCAL for offer in offers
    )
    asks_for_old = are_latched if offers else is_latched
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if are_reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=(
            DurabilityPolicy.TRANSIENT_LOCAL if asks_for_old else DurabilityPolicy.VOLATILE
        ),
    )
