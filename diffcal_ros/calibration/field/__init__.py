# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A modulus that varies over the body: one number a tetrahedron, or a point of a grid."""
