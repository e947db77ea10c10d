# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where a fit should start: shapes of the body over its modulus, placed on a coarse image."""
