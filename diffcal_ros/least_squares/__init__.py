# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sums of squares to second order, and their minima within bounds; they know no simulator."""
