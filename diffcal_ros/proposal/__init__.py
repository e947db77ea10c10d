# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scene proposed from a mesh and a recording: where the body is, and what of it is held."""
