# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Elements: shape functions, energies and forces, and the fixed pattern of their stiffness."""
