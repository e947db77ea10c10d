# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Fit the bundled recording, from Python.

What `diffcal calibrate bags/sample/bag --scene bags/sample/scene.yaml` does: read the scene, open
the recording that it names, find the marker, fuse the frames, and fit.

Printed: what was read, the parameters with their errors, and the outcome with its remedy, which is
empty where nothing needs one.
"""

from pathlib import Path

from diffcal_ros import calibrate, load_scene, open_inputs

SAMPLE = Path(__file__).resolve().parents[2] / 'bags' / 'sample'

inputs = open_inputs(load_scene(SAMPLE / 'scene.yaml'), [SAMPLE / 'bag'])
(observation,) = inputs.observations
result = calibrate(inputs.scene, inputs.observations)

print(f'{observation.frame_count} frames of {observation.depth.shape[1]} columns')
for parameter in result.parameters:
    print(f'{parameter.name:18} {parameter.value:12.5g} +- {parameter.std_error:.2g}')
print(f'{result.outcome.value}, gap {1e3 * result.gap_end.median:.3f} mm')
