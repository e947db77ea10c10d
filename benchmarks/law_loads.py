# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Which loads tell stable neo-Hookean and Mooney-Rivlin apart: ranked on the truth of each.

A soft beam hangs; together with that it is twisted, stretched or pushed together by its far end.
The truth is on a finer mesh than the fits, with the noise and the steps of an L515.
"""

import argparse
from dataclasses import replace
from typing import Any

from coarsening import CAMERA, DEPTH_FROM_WORLD, scene, SIZE
from diffcal_ros.calibration.law_ranking import rank_laws
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.depth.tracer import DepthTracer
from diffcal_ros.errors import InputError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.rigid_transform import apply
from diffcal_ros.scene.law_choice import with_law
from diffcal_ros.scene.model import HeldPart, Scene, Turn
from diffcal_ros.synthetic.posed_body import pose_body
from measuring import write
import numpy as np

LAWS = ('stable_neo_hookean', 'mooney_rivlin')
MODULUS = 40e3
FINE, COARSE = (15, 5, 5), (10, 4, 4)
# Turn [degrees] and pull [share of the length] of the far end; None: it hangs alone.
LOADS: dict[str, tuple[float, float] | None] = {
    'hanging': None,
    'and twisted by 45 degrees': (45.0, 0.0),
    'and twisted by 90 degrees': (90.0, 0.0),
    'and twisted by 180 degrees': (180.0, 0.0),
    'and stretched by 15 %': (0.0, 0.15),
    'and stretched by 30 %': (0.0, 0.30),
    'and pushed together by 10 %': (0.0, -0.10),
    'and twisted by 90 degrees, stretched by 30 %': (90.0, 0.30),
}


def loaded(cells: tuple[int, int, int], modulus: float, load: Any, law: str) -> Scene:
    """Hang the beam, and where there is a load, hold it in that way too."""
    own = with_law(scene(cells, Element.QUADRATIC, modulus), law)
    if load is None:
        return own
    (hanging,) = own.observations
    far = np.flatnonzero(own.mesh.rest_positions[:, 0] > SIZE[0] - 1e-9).astype(np.int32)
    pull = np.array([load[1] * SIZE[0], 0.0, 0.0])
    turn = Turn(np.array([1.0, 0.0, 0.0]), np.deg2rad(load[0]), translation=pull)
    both = (*hanging.held, HeldPart('far', far, turn))
    return replace(own, observations=(hanging, replace(hanging, name='loaded', held=both)))


def filmed(truth: Scene, seed: int) -> list[Observation]:
    """Render every posture."""
    random, seen = np.random.default_rng(seed), []
    for index, setup in enumerate(truth.observations):
        body = pose_body(truth, setup)
        points = apply(DEPTH_FROM_WORLD, body.positions)
        depth = DepthTracer(body.triangles, len(points), CAMERA).trace(points).full_depth()
        noisy = depth + random.normal(scale=0.00014, size=depth.shape)
        stepped = (np.round(noisy / 0.00025) * 0.00025).astype(np.float32)
        seen.append(Observation(setup.name, index, stepped, CAMERA, DEPTH_FROM_WORLD))
    return seen


def main() -> None:
    """Rank under every load."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--name', default='law_loads')
    arguments = parser.parse_args()
    rows = []
    for name, load in LOADS.items():
        for truth in LAWS:
            row: dict[str, Any] = {'load': name, 'truth': truth}
            try:
                seen = filmed(loaded(FINE, MODULUS, load, truth), seed=7)
                start = loaded(COARSE, 1.3 * MODULUS, load, truth)
                settings = CalibrationSettings(with_mesh_error=False)
                ranking = rank_laws(start, seen, settings, laws=LAWS)
                gaps = {fit.law: 1e3 * fit.held_out.rms for fit in ranking if fit.held_out}
                row |= {'first': ranking[0].law, 'held_out_rms_mm': gaps}
                row['is_right'] = ranking[0].law == truth
            except InputError as error:
                row['failure'] = str(error)
            rows.append(row)
            print(row, flush=True)
    write(arguments.name, {'modulus_pa': MODULUS, 'rows': rows})


if __name__ == '__main__':
    main()
