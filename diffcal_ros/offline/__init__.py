# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""From recordings to results, in process: nothing dropped, the same numbers every time."""
