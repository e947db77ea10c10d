# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Running Warp: its start, its cache of kernels, launches and arrays."""
