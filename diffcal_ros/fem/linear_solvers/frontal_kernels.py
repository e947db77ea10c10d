# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
# mypy: ignore-errors
"""Warp kernels of a multifrontal factorisation: what is left of a child goes into its parent."""

from functools import cache
from typing import Any

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


@wp.kernel(enable_backward=False, module='unique')
def add_columns(
    # In:
    which: wp.array[wp.int32],  # (3,) a child, its first column and the end of its columns
    width: wp.int32,  # numbers of a node: each entry of the last three arrays has so many
    table: wp.array2d[wp.int32],  # (fronts, 7), see `FrontalPlan.table`
    into: wp.array[wp.int32],  # places of the nodes of all borders in their parents; one more
    left: wp.array[Any],  # matrices that wait to be added
    # Out:
    store: wp.array[Any],
    update: wp.array[Any],  # matrices that wait beside those
):
    """Add columns of a child's lower triangle to its parent: one thread, node by node."""
    child = which[0]
    parent = table[child, 0]
    size = table[child, 2] / width
    indices = table[child, 3] / width
    own = table[parent, 1] / width
    border = table[parent, 2] / width
    for column in range(which[1], which[2]):
        row = column / width
        source = table[child, 4] / width + column * size
        b = into[indices + row] * width + column % width
        if b < own * width:
            at = table[parent, 5] / width + b * own
            place = into[indices + row]
            while row < size and place < own:
                store[at + place] = store[at + place] + left[source + row]
                row += 1
                place = into[indices + row]
            at = table[parent, 6] / width + b * border - own
            while row < size:
                to = at + into[indices + row]
                store[to] = store[to] + left[source + row]
                row += 1
        else:
            at = table[parent, 4] / width + (b - own * width) * border - own
            while row < size:
                to = at + into[indices + row]
                update[to] = update[to] + left[source + row]
                row += 1


@cache
def columns_kernel(entry: Any) -> Any:
    """Return `add_columns` for entries of a type: a vector of a node's numbers, or one number."""
    numbers = wp.array(dtype=entry)
    return wp.overload(add_columns, {'left': numbers, 'store': numbers, 'update': numbers})
