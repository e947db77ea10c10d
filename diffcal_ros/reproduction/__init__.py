# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The paper's experiments as data: each row of its tables is a YAML file in `rows`."""
