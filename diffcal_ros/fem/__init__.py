# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Differentiable finite elements: energy laws, elements, equilibrium and its derivatives."""
