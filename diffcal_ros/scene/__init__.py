# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The scene: body, clamp, material, rig, camera, and what to fit."""
