# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What runs beside the nodes: fits, tracking, diagnoses."""
