# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A folder of `diffcal calibrate` read again: its scene, its recordings and its numbers."""

from collections.abc import Sequence
from dataclasses import dataclass
import json
from pathlib import Path
from typing import Any

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import InputError
from diffcal_ros.offline.calibrate_recordings import OfflineInputs, open_inputs
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
import numpy as np

_RESULT, _FITTED_SCENE = 'result.json', 'fitted_scene.yaml'


@dataclass(frozen=True)
class FitFolder:
    """What a fit's folder holds.

    Attributes:
        path: the folder.
        document: its result.json.
        scene: with fitted values; as it was before where nothing was fitted.
    """

    path: Path
    document: dict[str, Any]
    scene: Scene

    @property
    def values(self) -> dict[str, float]:
        """All parameters in SI units by name, nuisances too."""
        return {
            name: float(own['value'])
            for name, own in self.document['parameters'].items()
            if own['value'] is not None
        }

    def open(
        self,
        bags: Sequence[Path] = (),
        *,
        pose_source: str | None = None,
        depth_topic: str | None = None,
        allow_truncated: bool = False,
    ) -> OfflineInputs:
        """Open the recordings again; see `open_inputs`.

        Args:
            bags: in place of those that the fit was made from.
            pose_source: as it was in the fit, where that was stated.
            depth_topic: where a recording has several; None: the one that the fit took.
            allow_truncated: read what is left of damaged ones.

        Raises:
            InputError: when one cannot be used.
        """
        recorded = self.document.get('recordings') or []
        topics = {own['depth_topic'] for own in recorded}
        if depth_topic is None and len(topics) == 1:
            (depth_topic,) = topics
        return open_inputs(
            self.scene,
            bags or self._bags([Path(own['path']) for own in recorded]),
            pose_source=pose_source,
            depth_topic=depth_topic,
            allow_truncated=allow_truncated,
        )

    def _bags(self, recorded: Sequence[Path]) -> Sequence[Path]:
        """Return the fit's recordings; none where the scene's own are to be taken."""
        if recorded and all(path.exists() for path in recorded):
            return recorded
        # Paths of a result start where the fit was run, those of a scene at its file.
        if all(setup.bag is not None for setup in self.scene.observations):
            return ()
        named = ', '.join(str(path) for path in recorded) or 'no recording'
        raise InputError(
            f'{self.path / _RESULT} names {named}, not found from here: give the recordings after '
            'the folder'
        )

    def calibration(self, inputs: OfflineInputs) -> Calibration:
        """Return the fit's model, standing at the fitted values.

        Raises:
            InputError: when the scene and recordings are not what was fitted.
        """
        asked = self.document['settings']
        settings = CalibrationSettings(
            fit=tuple(asked['fit']), loss=asked['loss'], optimizer=asked['optimizer']
        )
        calibration = Calibration(inputs.scene, inputs.observations, settings)
        start, values = calibration.parameters.start(), self.values
        calibration.coordinates = np.array(
            [
                parameter.coordinate(values[parameter.name]) if parameter.name in values else usual
                for parameter, usual in zip(calibration.parameters, start, strict=True)
            ]
        )
        return calibration


def read_fit(folder: Path) -> FitFolder:
    """Read a folder of `diffcal calibrate --out`.

    Raises:
        InputError: when it holds no result, or its scene cannot be read.
    """
    path = folder / _RESULT
    if not path.is_file():
        raise InputError(
            f'{folder} holds no {_RESULT}: give the folder after --out of a `diffcal calibrate`'
        )
    try:
        document = json.loads(path.read_text(encoding='utf-8'))
        is_whole = all(
            isinstance(document[key], dict) for key in ('parameters', 'gap', 'settings')
        )
        source = document['scene']['path']
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(f'{path} is no result of `diffcal calibrate` ({error})') from error
    if not is_whole:
        raise InputError(f'{path} is no result of `diffcal calibrate`: fit again')
    fitted = folder / _FITTED_SCENE
    if not fitted.is_file() and (source is None or not Path(source).is_file()):
        raise InputError(
            f'{folder} holds no {_FITTED_SCENE}, and the scene {source} that {_RESULT} names is '
            'not found from here: run in the folder where the fit was run, or fit again'
        )
    return FitFolder(folder, document, load_scene(fitted if fitted.is_file() else Path(source)))
