# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is compared: residuals, their scales and correlation, costs, the gap."""
