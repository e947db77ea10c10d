# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The ROS 2 nodes: messages in and out; what they do is in `diffcal_ros.live`."""
