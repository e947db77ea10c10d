# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Many recordings fitted one by one, and what they say together of the materials."""
