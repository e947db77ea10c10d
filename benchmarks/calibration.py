# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""One calibration of a hanging beam from +-45 %, on the public capture h_e_c."""

from dataclasses import replace
import os
from pathlib import Path
import tempfile

from diffcal_ros.calibration.calibrate import calibrate
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.offline.calibrate_recordings import open_inputs
from diffcal_ros.recording.dataset.import_case import import_case
from diffcal_ros.scene.load import load_scene
from measuring import write
import numpy as np

_CENTRES = {Element.QUADRATIC: 132e3, Element.LINEAR: 62e3}


def main() -> None:
    """Fit from ten starts with each element."""
    folder = os.environ.get('DIFFCAL_DATA')
    if not folder:
        raise SystemExit('set DIFFCAL_DATA to a clone of the public DiffCal data set')
    with tempfile.TemporaryDirectory() as out:
        import_case(folder, 'h_e_c', out)
        scene = load_scene(Path(out) / 'scene.yaml')
        observations = open_inputs(scene, [Path(out) / 'bag']).observations
    figures = {}
    for element, centre in _CENTRES.items():
        random = np.random.default_rng(7)
        seconds, moduli, iterations = [], [], []
        for share in [0.0, *random.uniform(-0.45, 0.45, size=10)]:
            (region,) = scene.regions
            start = replace(region.youngs_modulus, start=centre * (1.0 + share))
            regions = (replace(region, youngs_modulus=start),)
            moved = replace(scene, element=element, regions=regions)
            result = calibrate(moved, observations, CalibrationSettings(with_mesh_error=False))
            seconds.append(result.seconds)
            moduli.append(result['youngs_modulus'].value)
            iterations.append(result.iterations)
        # The first fit compiles kernels or loads them.
        figures[element.value] = {
            'first_s': seconds[0],
            'median_s': float(np.median(seconds[1:])),
            'iterations': iterations[1:],
            'modulus_pa': float(np.mean(moduli[1:])),
            'spread': float(np.ptp(moduli[1:]) / np.mean(moduli[1:])),
        }
    write('calibration', figures)


if __name__ == '__main__':
    main()
