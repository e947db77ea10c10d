# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a fit answers: parameters with errors, the outcome, and where it came from."""
