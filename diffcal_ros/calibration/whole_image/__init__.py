# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's losses over whole images, and the optimiser that it minimises them with."""
