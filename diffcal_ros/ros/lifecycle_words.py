# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a lifecycle node stands, and what to call to get on from there."""

from enum import Enum


class Stand(str, Enum):
    """The primary states of a lifecycle node."""

    UNCONFIGURED = 'unconfigured'
    INACTIVE = 'inactive'
    ACTIVE = 'active'
    FINALIZED = 'finalized'

    def words(self, node: str) -> str:
        """Say what the state means and what to do.

        Args:
            node: its whole name.
        """
        return _WORDS[self].format(node=node)


_WORDS = {
    Stand.UNCONFIGURED: 'unconfigured, no scene is loaded: call ros2 lifecycle set {node} '
    'configure, then activate',
    Stand.INACTIVE: 'inactive, nothing is listened to: call ros2 lifecycle set {node} activate',
    Stand.ACTIVE: 'active',
    Stand.FINALIZED: 'finalized, it was shut down for good: end this process and start the node '
    'again',
}
