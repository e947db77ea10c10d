# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Record a simulated body: depth, colour and camera poses, the truth in a file of its own."""

from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from diffcal_ros import __version__
from diffcal_ros.atomic_file import write_json_atomically, write_text_atomically
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.depth.tracer import OutOfViewError
from diffcal_ros.depth_frame import DepthFrame
from diffcal_ros.errors import InputError, RecordingError, SceneError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.recording.bag_writer import BagWriter
from diffcal_ros.recording.topics.color_frame import ColorFrame
from diffcal_ros.recording.topics.names import COLOR_FRAME, DEPTH_FRAME
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.refinement import refined_scene
from diffcal_ros.scene.sections.modulus_field import FIELD_FILE
from diffcal_ros.synthetic.color_picture import expose
from diffcal_ros.synthetic.filming import line_by_line, Timing
from diffcal_ros.synthetic.lidar import LidarModel
from diffcal_ros.synthetic.moving_body import move_body, MovingBodyFilm
from diffcal_ros.synthetic.posed_body import pose_body
from diffcal_ros.synthetic.recorded_scene import scene_text, write_files
from diffcal_ros.synthetic.rig import make_rig, Rig
from diffcal_ros.synthetic.scan import Scan
from diffcal_ros.synthetic.viewpoint import COLOR_CAMERA, DEPTH_CAMERA, DEPTH_FROM_COLOR
import numpy as np

_FIRST_STAMP_NS = 1_700_000_000_000_000_000
_COLOR_DELAY_NS = 4_000_000


@dataclass(frozen=True)
class RecorderSettings:
    """How to record.

    Attributes:
        timing: of the depth images.
        color_frames: colour images, evenly among them.
        seed: of the noise.
        element: that the true body is made of.
        integrator: that moves it; None: the scene's.
        time_step: of that [s]; None: the scene's.
        is_refined: simulate it at half the mesh size.
        start_factor: by which the written scene starts away from the truth.
        camera_position: of the depth camera in the world [m]; None: the scene's stored pose, or
            one that sees the body and the marker.
        depth_camera: where the scene gives none.
        color_camera: likewise.
        lidar: the depth camera's errors.
    """

    timing: Timing = field(default_factory=Timing)
    color_frames: int = 5
    seed: int = 0
    element: Element = Element.QUADRATIC
    integrator: str | None = None
    time_step: float | None = None
    is_refined: bool = False
    start_factor: float = 1.4
    camera_position: tuple[float, float, float] | None = None
    depth_camera: PinholeCamera = DEPTH_CAMERA
    color_camera: PinholeCamera = COLOR_CAMERA
    lidar: LidarModel = field(default_factory=LidarModel)

    def __post_init__(self) -> None:
        if not 0 <= self.color_frames <= self.timing.frames:
            raise InputError(
                f'{self.timing.frames} depth and {self.color_frames} colour frames were asked '
                'for: give no more colour than depth frames'
            )
        if self.time_step is not None and not 1e-6 <= self.time_step <= 0.1:
            raise InputError(f'the time step is {self.time_step:g} s: give 1e-6 to 0.1')
        if self.seed < 0:
            raise InputError(f'the seed is {self.seed}: give 0 or more')
        if not 0.1 <= self.start_factor <= 10.0:
            raise InputError(f'the start factor is {self.start_factor:g}: give 0.1 to 10')


@dataclass(frozen=True)
class SyntheticRecording:
    """What was written.

    Attributes:
        scene: scene file for a calibration.
        bags: recordings by observation.
        truth: file with the true values.
        notes: what a person should know.
    """

    scene: Path
    bags: dict[str, Path]
    truth: Path
    notes: tuple[str, ...]


def record(
    scene: Scene,
    out: Path,
    settings: RecorderSettings | None = None,
    *,
    overwrite: bool = False,
    report: Callable[[str], None] = lambda _: None,
) -> SyntheticRecording:
    """Simulate a scene's start values and record what cameras would see.

    Args:
        scene: read from a file; its start values are the truth.
        out: folder to write to: `bag` (or `bag_<observation>`), `scene.yaml`, the mesh, and
            `truth.json`.
        settings: how to record.
        overwrite: replace a recording that is there.
        report: called with what is being done.

    Raises:
        InputError: when the scene cannot be simulated or seen, or `out` cannot be written.
    """
    settings = settings or RecorderSettings()
    _check_target(scene, out, overwrite)
    true_scene = replace(
        scene,
        element=settings.element,
        depth_camera=scene.depth_camera or settings.depth_camera,
        color_camera=scene.color_camera or settings.color_camera,
    )
    if settings.is_refined:
        true_scene = refined_scene(true_scene)
    films = []
    for setup in true_scene.observations:
        report(f'simulating {setup.name}, {true_scene.mesh.tet_count} tetrahedra')
        films.append(_film(true_scene, setup, settings))
    rigs = [
        make_rig(true_scene, setup, film.first, settings.camera_position, film.positions)
        for setup, film in zip(true_scene.observations, films, strict=True)
    ]
    is_only = len(rigs) == 1
    bags = {rig.name: out / ('bag' if is_only else f'bag_{rig.name}') for rig in rigs}
    text = scene_text(
        scene,
        bags={name: bag.name for name, bag in bags.items()},
        lidar=settings.lidar,
        start_factor=settings.start_factor,
        poses=_stored_poses(scene, rigs),
    )
    for number, rig in enumerate(rigs):
        report(f'filming {rig.name}, {settings.timing.frames} depth images')
        _write_bag(rig, films[number], bags[rig.name], settings, number, overwrite)
    write_files(scene, out)
    truth = out / 'truth.json'
    write_json_atomically(truth, _truth(true_scene, rigs, films, settings))
    write_text_atomically(out / 'scene.yaml', text)
    return SyntheticRecording(out / 'scene.yaml', bags, truth, _notes(scene, rigs))


def _check_target(scene: Scene, out: Path, overwrite: bool) -> None:
    """Refuse to write over the scene that is being simulated."""
    if scene.path is None or not scene.document:
        raise ValueError('the scene was built in memory: only one read from a file is recorded')
    target = out / 'scene.yaml'
    if target.exists() and target.samefile(scene.path):
        raise RecordingError(f'{target} is the scene to simulate: choose another folder')
    if target.exists() and not overwrite:
        raise RecordingError(f'{target} exists already: choose another folder, or add --overwrite')


def _stored_poses(scene: Scene, rigs: Sequence[Rig]) -> dict[str, Any]:
    """Return the camera poses that the scene must store: without a marker nothing finds them."""
    return {
        rig.name: rig.depth_from_world
        for rig, setup in zip(rigs, scene.observations, strict=True)
        if scene.marker is None
        or setup.stored_depth_from_world is not None
        or setup.pose.source in ('stored', 'tf', 'topic', 'fixture')
    }


def _film(scene: Scene, setup: ObservationSetup, settings: RecorderSettings) -> MovingBodyFilm:
    """Simulate the body at all instants at which it is looked at; once where it is at rest."""
    if setup.motion is None:
        body = pose_body(scene, setup)
        return MovingBodyFilm(body, body.positions[None])
    timing = settings.timing
    times = timing.times()[:, None] + timing.instants()
    return move_body(
        scene,
        setup,
        times.ravel(),
        integrator=settings.integrator,
        time_step=settings.time_step,
    )


def _write_bag(
    rig: Rig,
    film: MovingBodyFilm,
    path: Path,
    settings: RecorderSettings,
    number: int,
    overwrite: bool,
) -> None:
    timing = settings.timing
    # Each image has its own source of noise: more frames do not change the earlier ones.
    bias_random = np.random.default_rng([settings.seed, number, 0])
    bias = settings.lidar.bias_field(rig.depth_scan.depth.shape, bias_random)
    later_ns = timing.stamps_ns(np.random.default_rng([settings.seed, number, 3]))
    kept = timing.kept(np.random.default_rng([settings.seed, number, 4]))
    places = np.linspace(0, len(kept) - 1, min(settings.color_frames, len(kept))).round()
    colored = {kept[int(place)] for place in places}
    with BagWriter(path, overwrite=overwrite) as bag:
        bag.write_depth_from_color(
            DEPTH_FROM_COLOR,
            depth_frame=DEPTH_FRAME,
            color_frame=COLOR_FRAME,
            stamp_ns=_FIRST_STAMP_NS,
        )
        for index in kept:
            stamp = _FIRST_STAMP_NS + later_ns[index]
            random = np.random.default_rng([settings.seed, number, 1, index])
            depth = settings.lidar.measure(_scan(rig, film, timing, index), bias, random)
            bag.write_depth_camera(rig.depth_camera, stamp_ns=stamp, frame_id=DEPTH_FRAME)
            bag.write_depth(
                DepthFrame(depth, stamp, DEPTH_FRAME), encoding=settings.lidar.encoding
            )
            if index in colored:
                later = stamp + _COLOR_DELAY_NS
                random = np.random.default_rng([settings.seed, number, 2, index])
                picture = expose(rig.color_image, random)
                bag.write_color_camera(rig.color_camera, stamp_ns=later, frame_id=COLOR_FRAME)
                bag.write_color(ColorFrame(picture, later, COLOR_FRAME))


def _scan(rig: Rig, film: MovingBodyFilm, timing: Timing, index: int) -> Scan:
    """Return what the depth camera sees in one frame."""
    if len(film.positions) == 1:
        return rig.depth_scan
    count = len(timing.instants())
    try:
        scans = [rig.scan(film.at(index * count + k)) for k in range(count)]
    except OutOfViewError as error:
        raise SceneError(
            f'the body of {rig.name} leaves the view of the synthetic camera: {error}'
        ) from error
    return line_by_line(scans)


def _truth(
    scene: Scene, rigs: Sequence[Rig], films: Sequence[MovingBodyFilm], settings: RecorderSettings
) -> dict[str, Any]:
    """Say what the recording was made with, in SI units."""
    lidar = settings.lidar
    return {
        'made_by': f'diffcal_ros {__version__}',
        'parameters': {
            region.name: {
                name: getattr(region, name).start
                for name in ('youngs_modulus', 'poissons_ratio', 'density', 'damping')
                if getattr(region, name) is not None
            }
            for region in scene.regions
        },
        'cables': {
            cable.name: {
                'rest_length': cable.rest_length.start,
                'stiffness': cable.stiffness.start,
                'length': cable.length,
            }
            for cable in scene.cables
        },
        'modulus_field': None if scene.relative_modulus is None else FIELD_FILE,
        'element': scene.element.value,
        'tet_count': scene.mesh.tet_count,
        'law': scene.law,
        'lame_convention': scene.convention.value,
        'seed': settings.seed,
        'timing': asdict(settings.timing),
        'sensor': {name: getattr(lidar, name) for name in lidar.__dataclass_fields__},
        'depth_from_color': DEPTH_FROM_COLOR.tolist(),
        'observations': {
            rig.name: {
                'depth_from_world': rig.depth_from_world.tolist(),
                'largest_displacement': film.first.largest_displacement,
                **_motion_truth(setup),
            }
            for rig, film, setup in zip(rigs, films, scene.observations, strict=True)
        },
    }


def _motion_truth(setup: ObservationSetup) -> dict[str, Any]:
    if setup.motion is None:
        return {}
    return {'release_time': setup.motion.release_time.start}


def _notes(scene: Scene, rigs: Sequence[Rig]) -> tuple[str, ...]:
    notes = [
        f'{rig.name}: the body or the marker is partly outside an image'
        for rig in rigs
        if not rig.sees_all
    ]
    if scene.marker is None and not all(setup.pose.source for setup in scene.observations):
        notes.append('the scene has no marker: calibrate with --pose stored')
    return tuple(notes)
