# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is fitted: parameters, their coordinates, bounds and priors."""
