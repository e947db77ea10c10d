# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The page of a proposed scene: the body where it was found, the clamp in its colour."""

from html import escape
from pathlib import Path
from typing import Any

from diffcal_ros.atomic_file import write_text_atomically
from diffcal_ros.proposal.propose import Proposal
from diffcal_ros.report import palette
from diffcal_ros.report.figures.depth_panel import scale_bar, shade_mask, show_image
from diffcal_ros.report.figures.figure_png import figure_html, new_figure
from diffcal_ros.report.figures.observed_view import observed_views, ObservedView
from diffcal_ros.report.pages.page_style import document
from diffcal_ros.report.scene_picture.scene_legend import HELD_COLOR
import numpy as np

_WIDTH = 5.6  # Of a panel [inch].
_HEIGHTS = (3.0, 8.0)
_MARGIN = 0.03  # Beyond the body's nearest and farthest point [m].


def write_proposal_page(path: Path, proposal: Proposal) -> None:
    """Write one page that needs nothing else."""
    fit = proposal.found.fit
    view = observed_views(proposal.calibration, fit.result)[0]
    gap = fit.result.gap_end
    doubts = ''.join(f'<li>{escape(doubt)}</li>' for doubt in proposal.doubts)
    listed = f'<h2>What to check</h2><ul class="warnings">{doubts}</ul>' if doubts else ''
    figure = figure_html(
        proposal_figure(proposal, view),
        'the proposed body over the measured depth',
        'Left: measured depth. Right: the proposed body over it, its free part in blue, what the '
        'clamp holds in black.',
    )
    title = escape(proposal.draft.name)
    body = (
        f'<h1>{title}: proposed scene</h1>'
        f'<p class="soft">Gap: median {1e3 * gap.median:.2g} mm on '
        f'{100 * gap.coverage_in_sight:.0f} % of the body in sight.</p>'
        f'{figure}{listed}<h2>scene.yaml</h2><pre class="wide"><code>'
        f'{escape(proposal.draft.text(path.parent))}</code></pre>'
    )
    write_text_atomically(path, document(f'{proposal.draft.name}: proposed scene', body))


def proposal_figure(proposal: Proposal, view: ObservedView) -> Any:
    """Draw the measured depth alone, and with the proposed body over it."""
    rows, columns = view.rows, view.columns
    aspect = (rows.stop - rows.start) / (columns.stop - columns.start)
    figure = new_figure(2 * _WIDTH, float(np.clip(_WIDTH * aspect, *_HEIGHTS)) + 0.4)
    axes = figure.subplots(1, 2)
    drawn, observed = view.fitted.depth, view.observation.depth.astype(np.float64)
    limits = (
        1e3 * (float(np.nanmin(drawn)) - _MARGIN),
        1e3 * (float(np.nanmax(drawn)) + _MARGIN),
    )
    for panel in axes:
        show_image(panel, view, 1e3 * observed, palette.depth_map(), limits)
    is_held = _is_held(proposal, view)
    is_body = view.fitted.faces >= 0
    shade_mask(axes[1], view, is_body & ~is_held, palette.FITTED)
    shade_mask(axes[1], view, is_held, HELD_COLOR)
    axes[0].set_title('measured depth', fontsize=12)
    axes[1].set_title('proposed body', fontsize=12)
    scale_bar(axes[0], view)
    return figure


def _is_held(proposal: Proposal, view: ObservedView) -> Any:
    """Return the pixels that show the held part, shape (H, W)."""
    model = proposal.calibration.model
    body = model.body(view.observation)
    is_held_node = np.zeros(body.discretisation.node_count, dtype=bool)
    is_held_node[body.held_nodes] = True
    triangles = body.discretisation.surface_triangles
    is_held_face = np.append(is_held_node[triangles].all(axis=1), False)
    return is_held_face[view.fitted.faces] & (view.fitted.faces >= 0)
