# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A subscription that asks of its publishers what they offer, whoever comes first."""

from collections.abc import Callable
from typing import Any

from diffcal_ros.ros.qos import strictest_offered
from rcl_interfaces.msg import ParameterDescriptor
from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

_AS_OFFERED = 'system_default'
_CURE = (
    'messages are being lost on {topic}: large images need more shared memory at the publisher; '
    'start it with FASTRTPS_DEFAULT_PROFILES_FILE set to config/fastdds_large_images.xml of '
    'diffcal_ros'
)


class AdaptiveSubscription:
    """Subscribes again whenever a publisher comes that offers less, or none such is left.

    `qos_overrides.<topic>.subscription.reliability`, `.durability` and `.depth` go before it.
    """

    def __init__(
        self,
        node: Node,
        msg_type: Any,
        topic: str,
        callback: Callable[[Any, dict[str, int]], None],
        *,
        depth: int = 5,
        is_latched: bool = False,
        is_raw: bool = False,
        on_lost: Callable[[int], None] = lambda count: None,
    ) -> None:
        """Subscribe.

        Args:
            node: whose it is.
            msg_type: of the messages.
            topic: relative name.
            callback: gets each message and when it was published and received.
            depth: messages that are kept.
            is_latched: what was sent before is wanted too.
            is_raw: messages come serialised.
            on_lost: told how many messages were lost.
        """
        self._node = node
        self._msg_type = msg_type
        self._callback = callback
        self._on_lost = on_lost
        self._depth = depth
        self._is_latched = is_latched
        self._is_raw = is_raw
        self._has_told = False
        self.topic = node.resolve_topic_name(topic)
        # Not within an event of the subscription that is to go.
        self._look_again = node.create_guard_condition(self._adapt)
        self._qos = self._wanted()
        self._subscription = self._subscribe()

    @property
    def qos(self) -> QoSProfile:
        """What is asked for now."""
        return self._qos

    def destroy(self) -> None:
        """End it."""
        self._node.destroy_guard_condition(self._look_again)
        self._node.destroy_subscription(self._subscription)

    def _adapt(self) -> None:
        wanted = self._wanted()
        if wanted != self._qos:
            self._node.destroy_subscription(self._subscription)
            self._qos = wanted
            self._subscription = self._subscribe()

    def _subscribe(self) -> Any:
        return self._node.create_subscription(
            self._msg_type,
            self.topic,
            self._callback,
            self._qos,
            raw=self._is_raw,
            event_callbacks=SubscriptionEventCallbacks(
                incompatible_qos=lambda event: self._look_again.trigger(),
                matched=lambda event: self._look_again.trigger(),
                message_lost=self._lost,
            ),
        )

    def _wanted(self) -> QoSProfile:
        offers = self._node.get_publishers_info_by_topic(self.topic)
        depth = self._override('depth', self._depth)
        qos = strictest_offered(offers, depth, is_latched=self._is_latched)
        reliability = self._override('reliability', _AS_OFFERED)
        durability = self._override('durability', _AS_OFFERED)
        if reliability != _AS_OFFERED:
            qos.reliability = ReliabilityPolicy[reliability.upper()]
        if durability != _AS_OFFERED:
            qos.durability = DurabilityPolicy[durability.upper()]
        return qos

    def _override(self, policy: str, usual: Any) -> Any:
        name = f'qos_overrides.{self.topic}.subscription.{policy}'
        if not self._node.has_parameter(name):
            descriptor = ParameterDescriptor(
                description=f'{policy} of the subscription to {self.topic}; '
                f'{_AS_OFFERED}: as its publishers offer',
                read_only=True,
            )
            self._node.declare_parameter(name, usual, descriptor)
        return self._node.get_parameter(name).value

    def _lost(self, event: Any) -> None:
        self._on_lost(event.total_count_change)
        if not self._has_told:
            self._has_told = True
            self._node.get_logger().warning(_CURE.format(topic=self.topic))


def noting(
    problems: dict[str, str], topic: str, callback: Callable[[Any], None]
) -> Callable[[Any, dict[str, int]], None]:
    """Return a callback that notes under `topic` what is wrong with the last message there."""

    def noted(message: Any, info: dict[str, int]) -> None:
        try:
            callback(message)
        except ValueError as error:
            problems[topic] = str(error)
        else:
            problems.pop(topic, None)

    return noted
