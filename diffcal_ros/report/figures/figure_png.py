# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Figures without a display, and PNG bytes of them."""

import base64
from io import BytesIO
from typing import Any

_DPI = 120


def new_figure(width: float, height: float) -> Any:
    """Return a figure of some inches, drawn by Agg."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=_DPI, layout='constrained')
    FigureCanvasAgg(figure)
    return figure


def png_bytes(figure: Any) -> bytes:
    """Draw a figure; the bytes depend on nothing but what is drawn."""
    layout = figure.get_layout_engine()
    if layout is not None:
        # Left to itself, Matplotlib draws everything once for the layout alone.
        layout.execute(figure)
        figure.set_layout_engine('none')
    buffer = BytesIO()
    figure.savefig(buffer, format='png', metadata={'Software': None})
    return buffer.getvalue()


def data_uri(png: bytes) -> str:
    """Return a PNG as a link that holds it."""
    return f'data:image/png;base64,{base64.b64encode(png).decode("ascii")}'


def figure_html(figure: Any, alternative: str, caption: str) -> str:
    """Return a figure with its caption for a page that needs nothing else."""
    return (
        f'<figure><img src="{data_uri(png_bytes(figure))}" alt="{alternative}">'
        f'<figcaption>{caption}</figcaption></figure>\n'
    )
