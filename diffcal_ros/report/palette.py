# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Colours of the figures, chosen to be told apart by everyone and in grey print."""

from functools import cache
from typing import Any

START = '#b45309'
FITTED = '#1d4ed8'
MEASURED = '#111827'
MEASURED_EDGE = '#facc15'
CABLE = '#c026d3'
MISSING = '#f5d0fe'
UNEXPLAINED = '#dc2626'
# From "too near" over grey to "too far"; beyond the scale each end turns dark.
_NEAR, _MIDDLE, _FAR = '#2b6cb0', '#e5e7eb', '#dd7a1c'
_NEARER, _FARTHER = '#0b2545', '#6b2d06'
BEYOND = '#d1d5db'
NO_DEPTH = '#ffffff'
LINES = ('#1d4ed8', '#b45309', '#0f766e', '#7e22ce', '#be123c', '#4d7c0f')
DASHES = ('-', '--', ':')


@cache
def residual_map() -> Any:
    """Return the diverging map of residuals."""
    from matplotlib.colors import LinearSegmentedColormap

    colors = LinearSegmentedColormap.from_list('residual', [_NEAR, _MIDDLE, _FAR], N=255)
    return colors.with_extremes(under=_NEARER, over=_FARTHER, bad=NO_DEPTH)


@cache
def one_colour_map(colour: str) -> Any:
    """Return a map of one colour, transparent where there is no value."""
    from matplotlib.colors import ListedColormap

    return ListedColormap([colour]).with_extremes(bad=(0.0, 0.0, 0.0, 0.0))


@cache
def depth_map() -> Any:
    """Return the map of depths; what lies beyond the body's range is grey."""
    from matplotlib import colormaps

    return colormaps['viridis_r'].with_extremes(under=BEYOND, over=BEYOND, bad=NO_DEPTH)


@cache
def field_map() -> Any:
    """Return the map of a modulus over a body, dark where it is soft."""
    from matplotlib import colormaps

    return colormaps['cividis']


@cache
def error_map() -> Any:
    """Return the map of a field's standard error, dark where little is known."""
    from matplotlib import colormaps

    return colormaps['Greys']


def correlation_color(value: float) -> tuple[str, str]:
    """Return background and text colour of a correlation."""
    end = _FAR if value > 0.0 else _NEAR
    fraction = min(abs(value), 1.0)
    mixed = [
        round((1.0 - fraction) * int(_MIDDLE[k : k + 2], 16) + fraction * int(end[k : k + 2], 16))
        for k in (1, 3, 5)
    ]
    red, green, blue = mixed
    is_dark = 0.299 * red + 0.587 * green + 0.114 * blue < 130.0
    return f'#{red:02x}{green:02x}{blue:02x}', '#ffffff' if is_dark else '#111827'
