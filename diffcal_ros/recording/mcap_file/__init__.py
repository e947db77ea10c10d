# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The container mcap: records, checksums, what is damaged, and what can be saved."""
