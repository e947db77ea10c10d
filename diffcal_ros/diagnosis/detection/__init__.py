# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Is there a disagreement, could it be noise or mesh, and how much may hide."""
