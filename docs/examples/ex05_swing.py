# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Find the damping of a body that is let go.

The beam lies with its free end on a ledge. The ledge is taken away, the beam swings, and a depth
camera films it at 30 Hz. The film is made here, with noise and on a mesh twice as fine, and then
read and fitted as one from a camera would be.

Printed: modulus, damping and the time of release, each with its error and its truth. Motion under
gravity shows them only as ratios to the density, which is therefore taken as known.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

from beam import write_scene
from diffcal_ros import (
    calibrate,
    CalibrationSettings,
    load_scene,
    open_inputs,
    record,
    RecorderSettings,
)
from diffcal_ros.synthetic.filming import Timing

TRUTH = {'youngs_modulus': 200e3, 'damping': 150.0, 'release_time': 0.08}
# Errors are then those of noise alone.
QUICK = CalibrationSettings(with_mesh_error=False)
SETTINGS = RecorderSettings(timing=Timing(12), color_frames=0, start_factor=1.3, seed=5)

silicone = {
    'youngs_modulus': TRUTH['youngs_modulus'],
    'poissons_ratio': 0.45,
    'density': 1080.0,
    'damping': TRUTH['damping'],
}
with TemporaryDirectory() as name:
    folder = Path(name)
    path = write_scene(
        folder,
        0.0,
        regions={'silicone': silicone},
        held={'clamp': {'box': {'x': [-1.0, 0.0]}}, 'ledge': {'box': {'x': [0.12, 1.0]}}},
        motion={
            'released': ['ledge'],
            'at': {'start': TRUTH['release_time'], 'min': 0.03, 'max': 0.2},
        },
        fit=['youngs_modulus', 'damping', 'release_time'],
    )
    film = record(load_scene(path), folder / 'film', SETTINGS)
    inputs = open_inputs(load_scene(film.scene), [])
    result = calibrate(inputs.scene, inputs.observations, QUICK)

for key, truth in TRUTH.items():
    fitted = next(one for one in result.parameters if one.name.startswith(key))
    print(f'{key:15} {fitted.value:10.5g} +- {fitted.std_error:8.2g}   truth {truth:g}')
print(
    f'{result.outcome.value}; {sum(seen.is_held_out for seen in inputs.observations)} of '
    f'{len(inputs.observations)} frames were kept from the fit'
)
