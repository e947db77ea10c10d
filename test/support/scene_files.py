# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parts of scene files."""

EXACT_POSE = {'position_std': 0.0, 'rotation_std_deg': 0.0}

BOARD = {
    'board': {'columns': 5, 'rows': 7, 'square': 0.03},
    'dictionary': 'DICT_4X4_50',
    'side': 0.022,
}
