# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Other packages timed beside us: the same body, the same run, one thread each."""
