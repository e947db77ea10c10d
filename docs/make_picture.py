# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Make the README's picture, the bundled sample calibrated: `python docs/make_picture.py`."""

from pathlib import Path
import tempfile

from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.offline.calibrate_recordings import open_inputs, run_calibration
from diffcal_ros.report.figures.picture import save_picture
from diffcal_ros.scene.load import load_scene

_ROOT = Path(__file__).resolve().parents[1]
_PICTURE = _ROOT / 'docs' / 'images' / 'measured_and_simulated.png'


def main() -> None:
    """Calibrate the sample and draw it."""
    scene = load_scene(_ROOT / 'bags' / 'sample' / 'scene.yaml')
    with tempfile.TemporaryDirectory() as folder:
        calibration, result = run_calibration(
            open_inputs(scene, []), CalibrationSettings(), Path(folder)
        )
    save_picture(_PICTURE, calibration, result)
    print(f'{_PICTURE.relative_to(_ROOT)}: {_PICTURE.stat().st_size / 1e3:.0f} kB')


if __name__ == '__main__':
    main()
