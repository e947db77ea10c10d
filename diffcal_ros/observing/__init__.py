# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Observations from frames and a camera pose, the same from a bag and live."""
