# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From coordinates to bodies, what cameras see of them, and derivatives."""
