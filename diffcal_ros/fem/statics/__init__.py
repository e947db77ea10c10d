# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Bodies at rest: equilibrium, its derivatives, and what a finer mesh would change."""
