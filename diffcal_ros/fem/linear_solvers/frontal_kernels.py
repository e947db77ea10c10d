# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""A Warp kernel of a factorisation on a GPU: what is left of a child goes into its parent."""

import warp as wp

wp.set_module_options({'enable_backward': False})


@wp.kernel(enable_backward=False)
def add_update(
    # In:
    child: wp.int32,
    table: wp.array2d[wp.int32],  # (fronts, 7), see `FrontalPlan.table`
    into: wp.array[wp.int32],  # places of all borders in their parents
    left: wp.array[wp.float64],  # matrices that wait to be added
    # Out:
    store: wp.array[wp.float64],
    update: wp.array[wp.float64],  # matrices that wait beside those
):
    """Add column `tid` of a child's lower triangle to its parent."""
    column = wp.tid()
    parent = table[child, 0]
    size = table[child, 2]
    indices = table[child, 3]
    source = table[child, 4] + column * size
    own = table[parent, 1]
    border = table[parent, 2]
    b = into[indices + column]
    row = column
    if b < own:
        at = table[parent, 5] + b * own
        while row < size and into[indices + row] < own:
            to = at + into[indices + row]
            store[to] = store[to] + left[source + row]
            row += 1
        at = table[parent, 6] + b * border - own
        while row < size:
            to = at + into[indices + row]
            store[to] = store[to] + left[source + row]
            row += 1
    else:
        at = table[parent, 4] + (b - own) * border - own
        while row < size:
            to = at + into[indices + row]
            update[to] = update[to] + left[source + row]
            row += 1
