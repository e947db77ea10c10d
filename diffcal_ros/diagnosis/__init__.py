# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Where simulation and measurement disagree, and which effect the model lacks."""
