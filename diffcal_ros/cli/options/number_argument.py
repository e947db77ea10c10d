# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Numbers on the command line; Python's `float` also reads nan and 1e300."""

import argparse

_FARTHEST = 1e4


def coordinate(text: str) -> float:
    """Read a coordinate [m], for `argparse`."""
    try:
        value = float(text)
    except ValueError:
        value = float('nan')
    if not abs(value) <= _FARTHEST:
        raise argparse.ArgumentTypeError(f'{text!r} is no coordinate in metres')
    return value
