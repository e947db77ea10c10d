# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The recorded beam with a proposed scene that places it a little wrongly, without a search."""

from dataclasses import dataclass, replace
from pathlib import Path

from diffcal_ros.offline.calibrate_recordings import OfflineInputs, open_inputs
from diffcal_ros.proposal.draft import Draft
from diffcal_ros.proposal.hold import Hold
from diffcal_ros.scene.load import load_scene
from diffcal_ros.synthetic.recorder import SyntheticRecording
import numpy as np
from numpy.typing import NDArray

# The row of vertices at which the beam's clamp begins [m].
PLANE = 0.105
SHIFT = (0.0, -0.006, 0.0)


@dataclass(frozen=True)
class ArrangedBeam:
    """What the page of `diffcal init --web` starts from.

    Attributes:
        inputs: the recording.
        draft: that places the body `SHIFT` [m] from where it is, and 1.5 times too stiff.
        place: where the body is, shape (4, 4).
    """

    inputs: OfflineInputs
    draft: Draft
    place: NDArray[np.float64]


def arranged_beam(recorded: SyntheticRecording, modulus: float) -> ArrangedBeam:
    """Open the recording; nothing is searched for.

    Args:
        recorded: the beam.
        modulus: true one [Pa].
    """
    scene = replace(load_scene(recorded.scene), fit=('youngs_modulus', 'rigid_offset'))
    inputs = open_inputs(scene, [recorded.bags['observation']])
    place = scene.observations[0].world_from_object
    wrong = place.copy()
    wrong[:3, 3] += SHIFT
    hold = Hold(np.array([1.0, 0.0, 0.0]), PLANE)
    draft = Draft(
        name='beam',
        mesh_file=Path(recorded.scene).parent / 'beam.tet',
        unit='mm',
        bags=(recorded.bags['observation'],),
        gravity=scene.observations[0].gravity,
        world_from_object=wrong,
        hold=hold,
        held=hold.vertices(scene.mesh),
        youngs_modulus=1.5 * modulus,
        density=1080.0,
        poissons_ratio=0.45,
        marker=scene.marker,
        remarks={'placement': ('found in the depth image.',)},
    )
    return ArrangedBeam(inputs, draft, place)
