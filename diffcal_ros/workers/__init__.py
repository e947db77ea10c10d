# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Tasks done by processes of this machine or of a cluster, whatever becomes of a process."""
