# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Depth images of a triangle surface and their derivatives, silhouettes included."""
