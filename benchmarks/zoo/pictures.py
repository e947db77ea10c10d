# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pictures of cases, to see that they make sense."""

from pathlib import Path

from diffcal_ros.synthetic.scan import Thing
import matplotlib.figure
import numpy as np

from benchmarks.zoo.cases import Case


def draw_picture(case: Case, path: Path) -> None:
    """Draw what the camera measured, and what is what, into a PNG file."""
    depth, view = case.observation.depth, case.view
    is_body = view.scan.things == Thing.BODY
    middle = float(np.nanmedian(np.where(is_body, view.scan.depth, np.nan)))
    figure = matplotlib.figure.Figure(figsize=(12, 4.8), layout='constrained')
    left, right = figure.subplots(1, 2)
    image = left.imshow(1e3 * depth, vmin=1e3 * middle - 120, vmax=1e3 * middle + 120)
    figure.colorbar(image, ax=left, label='depth [mm]')
    # Light falls along the line of sight.
    right.imshow(np.where(np.isfinite(view.scan.depth), view.scan.cosine, 0.0), cmap='gray')
    right.imshow(np.where(is_body, 1.0, np.nan), cmap='autumn', alpha=0.25)
    figure.suptitle(
        f'{case.name}: {", ".join(case.kinds)}; {1e-3 * case.truth.youngs_modulus:.0f} kPa, '
        f'sags by {case.truth.sag:.0%}, {view.seen_share:.0%} seen'
    )
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path, dpi=70)
