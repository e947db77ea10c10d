# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Recordings of a simulated body, with known parameters, for tests and for trying things out."""
