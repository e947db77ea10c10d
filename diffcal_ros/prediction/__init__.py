# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A calibrated model run forward: what it will do, and what a depth camera would see of it."""
