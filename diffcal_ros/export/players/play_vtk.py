# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read body.vtu and print what it holds: `python play_vtk.py`; ParaView draws it.

Needs `pip install meshio`.
"""

from pathlib import Path

import meshio
import numpy as np


def read(path: Path) -> tuple[float, float, int]:
    """Return volume [m^3], mass [kg] and number of held vertices."""
    content = meshio.read(path)
    corners = content.points[content.cells_dict['tetra']]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1]) / 6.0
    density = content.cell_data_dict['density']['tetra']
    return float(volumes.sum()), float(volumes @ density), int(content.point_data['held'].sum())


def main() -> None:
    """Read the asset beside this script."""
    volume, mass, held = read(Path(__file__).with_name('body.vtu'))
    print(f'{1e6 * volume:.4g} cm^3, {mass:.4g} kg, {held} vertices held')


if __name__ == '__main__':
    main()
