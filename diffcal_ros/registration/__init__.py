# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A rigid part of the rig in a depth image: where it is, and how well that is known."""
