# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read body.usda and print what it holds; with Newton installed, let the body sink.

`python play_usd.py`; needs `pip install usd-core`, and `pip install newton` to play it. In Isaac
Sim, open or reference the file; in usdview it is drawn.
"""

import argparse
from pathlib import Path

import numpy as np
from pxr import Usd, UsdGeom, UsdShade


def read(path: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray, dict[str, float]]:
    """Return points [m], tetrahedra, held vertices and the numbers of the body's material."""
    stage = Usd.Stage.Open(str(path))
    (mesh,) = (UsdGeom.TetMesh(prim) for prim in stage.Traverse() if prim.IsA(UsdGeom.TetMesh))
    points = np.array(mesh.GetPointsAttr().Get(), dtype=float)
    tets = np.array(mesh.GetTetVertexIndicesAttr().Get())
    held = UsdGeom.Subset(mesh.GetPrim().GetChild('held')).GetIndicesAttr().Get()
    material, _ = UsdShade.MaterialBindingAPI(mesh.GetPrim()).ComputeBoundMaterial('physics')
    numbers = {
        name: float(material.GetPrim().GetAttribute(f'physics:{name}').Get())
        for name in ('youngsModulus', 'poissonsRatio', 'density')
    }
    return points, tets, np.array(held), numbers


def sink(path: Path, held: np.ndarray, seconds: float) -> np.ndarray:
    """Step the body in Newton; return the displacements [m], shape (V, 3)."""
    import newton

    builder = newton.ModelBuilder()
    builder.add_usd(str(path))
    for vertex in held:
        builder.particle_mass[vertex] = 0.0
        builder.particle_flags[vertex] = 0
    builder.color()
    model = builder.finalize()
    solver = newton.solvers.SolverVBD(model, iterations=20)
    state, after = model.state(), model.state()
    control, rest = model.control(), state.particle_q.numpy().copy()
    step = 1.0 / 300.0
    for number in range(round(seconds / step)):
        solver.step(state, after, control, None, step)
        state, after = after, state
        if number % 30 == 29:
            moved = np.linalg.norm(state.particle_q.numpy() - rest, axis=1).max()
            print(f'{(number + 1) * step:6.3f} s  moved by up to {1e3 * moved:.3f} mm')
    return np.asarray(state.particle_q.numpy() - rest, dtype=float)


def main() -> None:
    """Play the asset beside this script."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--seconds', type=float, default=1.0)
    args = parser.parse_args()
    path = Path(__file__).with_name('body.usda')
    points, tets, held, numbers = read(path)
    corners = points[tets]
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1]).sum() / 6.0
    print(f'{len(points)} points, {len(tets)} tetrahedra, {len(held)} held, {numbers}')
    print(f'{1e6 * volume:.4g} cm^3, {volume * numbers["density"]:.4g} kg')
    try:
        sink(path, held, args.seconds)
    except ImportError as error:
        print(f'to let it sink, install Newton and what it reads USD with ({error})')


if __name__ == '__main__':
    main()
