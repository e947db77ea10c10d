# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Frames on their way to a fit: the latest, a window of them, a swing."""
