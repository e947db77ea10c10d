# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Calibrate from recordings and write what was found."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from diffcal_ros.calibration.calibrate import Calibration, with_details
from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.calibration.profile_search import check_profiles, profile
from diffcal_ros.calibration.results.outcome import Outcome
from diffcal_ros.calibration.results.provenance import describe_fit
from diffcal_ros.calibration.results.result import CalibrationResult, IterationRecord, save_result
from diffcal_ros.calibration.settings import CalibrationSettings
from diffcal_ros.errors import PoseError, RecordingError, SceneError
from diffcal_ros.fem.activity import during
from diffcal_ros.offline.observe import observe
from diffcal_ros.offline.turn_sense import sense_note
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.recording import Recording
from diffcal_ros.scene.model import Scene

_UNFINISHED = (Outcome.DIVERGED, Outcome.INTERRUPTED)
Progress = Callable[[IterationRecord], bool]


@dataclass(frozen=True)
class OfflineInputs:
    """Everything an offline calibration starts from.

    Attributes:
        scene: loaded.
        recordings: opened.
        takes: observations made of each recording: one of a body at rest, one a frame of a
            motion.
        notes: what a person should know about them.
    """

    scene: Scene
    recordings: tuple[Recording, ...]
    takes: tuple[tuple[Observation, ...], ...]
    notes: tuple[str, ...]

    @property
    def observations(self) -> tuple[Observation, ...]:
        """All observations, in the order of the recordings."""
        return tuple(observation for take in self.takes for observation in take)


def open_inputs(
    scene: Scene,
    bags: Sequence[Path],
    *,
    pose_source: str | None = None,
    depth_topic: str | None = None,
    allow_truncated: bool = False,
) -> OfflineInputs:
    """Open recordings and make observations of them.

    Args:
        scene: loaded.
        bags: one an observation of the scene, in its order, or in any where the scene names them;
            or any number for a scene with one. Empty: the bags that the scene names.
        pose_source: `estimated` from the marker, `stored`, `tf`, `topic` or `fixture`; None: as
            the scene says, or else `estimated`.
        depth_topic: where a recording has several.
        allow_truncated: read what is left of damaged, cut-off and missing files; notes say what
            is lost.

    Raises:
        InputError: when a recording or its pose cannot be used.
    """
    pairs = _paired(scene, bags)
    recordings: list[Recording] = []
    takes: list[tuple[Observation, ...]] = []
    notes: list[str] = []
    for setup_index, bag in pairs:
        with _naming(bag):
            recording = open_recording(
                bag,
                depth_topic=depth_topic,
                depth_camera=scene.depth_camera,
                color_camera=scene.color_camera,
                allow_truncated=allow_truncated,
            )
            take, own_notes = observe(scene, setup_index, recording, pose_source=pose_source)
        recordings.append(recording)
        takes.append(take)
        notes.extend(f'{_name(take)}: {note}' for note in own_notes)
    return OfflineInputs(scene, tuple(recordings), tuple(takes), tuple(notes))


def _name(take: Sequence[Observation]) -> str:
    """Return a recording's name; frames of a motion have their time after it."""
    first = take[0]
    return first.name if first.instant is None else first.name.rpartition(', ')[0]


@contextmanager
def _naming(bag: Path) -> Iterator[None]:
    """Say which recording an error is about, where it does not say so itself."""
    try:
        yield
    except (RecordingError, PoseError) as error:
        if str(bag) in str(error):
            raise
        raise type(error)(f'{bag}: {error}') from error


def run_calibration(
    inputs: OfflineInputs,
    settings: CalibrationSettings,
    out: Path,
    *,
    on_iteration: Progress | None = None,
    report: Callable[[str], None] = lambda _: None,
) -> tuple[Calibration, CalibrationResult]:
    """Fit, and keep `out`/result.json complete after every step.

    Args:
        inputs: see `open_inputs`.
        settings: how to fit.
        out: folder of results.
        on_iteration: told of every step; returns False to stop.
        report: called with what is done afterwards.

    Raises:
        InputError: when something given is wrong, or `out` cannot be written.
    """
    count = inputs.scene.mesh.tet_count
    # Many solves of a large body, each of them short, take long as well.
    with during(f'fit of a body of {count:,} tetrahedra', 3 * count):
        return _run_calibration(inputs, settings, out, on_iteration, report)


def _run_calibration(
    inputs: OfflineInputs,
    settings: CalibrationSettings,
    out: Path,
    on_iteration: Progress | None,
    report: Callable[[str], None],
) -> tuple[Calibration, CalibrationResult]:
    calibration = Calibration(inputs.scene, inputs.observations, settings)
    check_profiles(calibration, settings.profile)
    details = describe_inputs(inputs, settings)
    history: list[IterationRecord] = []

    def keep(record: IterationRecord) -> bool:
        history.append(record)
        save_result(with_details(calibration.unfinished(history), **details), out / 'result.json')
        return on_iteration is None or on_iteration(record)

    result = with_details(calibration.run(keep), **details)
    if result.outcome not in _UNFINISHED:
        note = sense_note(inputs.scene, inputs.observations, settings, result)
        result = replace(result, warnings=(*result.warnings, *([note] if note else [])))
    if settings.profile and result.outcome not in _UNFINISHED:
        # What is found already is kept, should the profiles be interrupted.
        save_result(result, out / 'result.json')
        profiles = []
        for name in settings.profile:
            report(f'profile of {name}')
            profiles.append(profile(calibration, name))
        result = replace(result, profiles=tuple(profiles))
    save_result(result, out / 'result.json')
    return calibration, result


def describe_inputs(inputs: OfflineInputs, settings: CalibrationSettings) -> dict[str, object]:
    """Return versions, hashes and settings for result.json."""
    return {
        **describe_fit(inputs.scene, settings),
        'recordings': [
            {
                'name': _name(take),
                'path': str(recording.path),
                'sha256': recording.sha256,
                'depth_topic': recording.depth_topic,
                'frames': sum(observation.frame_count for observation in take),
                **_losses(recording),
            }
            for recording, take in zip(inputs.recordings, inputs.takes, strict=True)
        ],
        'notes': list(inputs.notes),
    }


def _losses(recording: Recording) -> dict[str, object]:
    """Return what result.json says of a recording that is not whole."""
    if recording.saved_count is None:
        return {}
    return {
        'damaged': True,
        'messages_read': recording.saved_count,
        'messages_lost': recording.lost_counts,
    }


def _paired(scene: Scene, bags: Sequence[Path]) -> list[tuple[int, Path]]:
    """Say which posture each bag shows."""
    setups = scene.observations
    if not bags:
        named = [(i, setup.bag) for i, setup in enumerate(setups) if setup.bag is not None]
        if len(named) < len(setups):
            raise SceneError(
                'no bag was given and the scene does not name one for every observation: give the '
                "recordings as arguments, or under 'observations' as 'bag'"
            )
        return [(i, bag) for i, bag in named if bag is not None]
    if len(setups) == 1 and setups[0].motion is not None and len(bags) > 1:
        raise SceneError(
            f'{len(bags)} bags were given for the motion {setups[0].name!r}: each has its own '
            "release, so list them under 'observations', each with its own 'motion'"
        )
    if len(setups) == 1:
        return [(0, bag) for bag in bags]
    if len(bags) != len(setups):
        raise SceneError(
            f'{len(bags)} bags were given for the {len(setups)} observations of the scene '
            f'({", ".join(setup.name for setup in setups)}): give one for each, in this order'
        )
    return _placed(scene, bags)


def _placed(scene: Scene, bags: Sequence[Path]) -> list[tuple[int, Path]]:
    """Pair as many bags as observations: by the scene where it names them, else by their order.

    A shell lists `bag_*` by the alphabet, a scene in its own order.
    """
    setups = scene.observations
    stated = [None if setup.bag is None else setup.bag.resolve() for setup in setups]
    given = [bag.resolve() for bag in bags]
    if len(set(given)) == len(bags) and set(given) == set(stated):
        return [(index, bags[given.index(bag)]) for index, bag in enumerate(stated) if bag]
    for index, bag in enumerate(given):
        if bag in stated and bag != stated[index]:
            raise SceneError(
                f'{bags[index]} was given for the observation {setups[index].name!r}, but the '
                f'scene says that it shows {setups[stated.index(bag)].name!r}: give one bag for '
                f"each, in the scene's order ({', '.join(setup.name for setup in setups)})"
            )
    return list(enumerate(bags))
