# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fiducial markers in colour images: one robust pose of the rig from many frames."""
