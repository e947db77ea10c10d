# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Reading a scene file: its text, its shapes, and every mistake at once."""
