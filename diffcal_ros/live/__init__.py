# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the nodes do, without ROS: windows, states, replay, background work."""
