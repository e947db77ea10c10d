# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A zoo of soft bodies in cluttered views, fitted from far starts.

The truth is of another mesh, element and solver than the fit: the blind generator's hexahedra.
"""
