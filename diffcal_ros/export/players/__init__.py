# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Scripts that are copied beside an asset: each loads it and lets the body sink under gravity.

They import nothing of this package, so that they run wherever the simulator is.
"""
