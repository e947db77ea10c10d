# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Propose a scene: read mesh and recordings, find the body, and write down what is not sure."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
import tempfile

from diffcal_ros.calibration.calibrate import Calibration
from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import InputError, SceneError
from diffcal_ros.marker import Marker
from diffcal_ros.offline.calibrate_recordings import OfflineInputs, open_inputs
from diffcal_ros.proposal.draft import Draft
from diffcal_ros.proposal.find_body import find_body, FoundBody
from diffcal_ros.proposal.fixture_hold import body_in_fixture
from diffcal_ros.proposal.gravity import Gravity, gravity_of
from diffcal_ros.proposal.hold import possible_holds
from diffcal_ros.proposal.level import level_placement, tilt
from diffcal_ros.proposal.mesh_unit import fitting_units, sizes
from diffcal_ros.recording.bag_reader import open_recording
from diffcal_ros.recording.recording import Recording
from diffcal_ros.rigid_transform import angle_between, apply
from diffcal_ros.scene.load import load_scene
from diffcal_ros.scene.model import Scene
from diffcal_ros.scene.sections.mesh_files import read_mesh
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

Tell = Callable[[str], None]
FloatArray = NDArray[np.float64]

SILICONE_DENSITY, SILICONE_RATIO = 1080.0, 0.49
# Where a modulus is not known yet [Pa].
_ANY_MODULUS = 1e5
# A place with less merit than this is nothing that looks like the body.
_LEAST_MERIT = 0.1
# A doubt about the clamp beyond this is told [m].
_SURE = 0.003
# So far from its place in the fixture a body is told to sit [mm], [degrees].
_SEAT, _SEAT_TURN = 2.0, 1.0
# A cantilever under its weight sags by the fourth power of its free length over the modulus, so
# that so many times the share of a doubt about the length is one about the modulus; told beyond.
_MODULUS_POWER, _MODULUS_SURE = 4.0, 0.05


@dataclass(frozen=True)
class Question:
    """What a person knows and files do not tell; None where they do not say.

    Attributes:
        unit: of the mesh.
        density: [kg/m^3].
        poissons_ratio: dimensionless.
        gravity: in the world frame [m/s^2].
        marker: on the rig.
        pose_frame: TF's name of the world.
        depth_topic: where a recording has several.
        sensor: name of a depth camera.
        pixel: column and row of a pixel on the soft body.
        fixture: closed surface of the clamp in the mesh's own coordinates, which gives the
            camera's pose.
    """

    unit: str | None = None
    density: float | None = None
    poissons_ratio: float | None = None
    gravity: tuple[float, float, float] | None = None
    marker: Marker | None = None
    pose_frame: str = ''
    depth_topic: str | None = None
    sensor: str = ''
    pixel: tuple[float, float] | None = None
    fixture: Path | None = None


@dataclass(frozen=True)
class Proposal:
    """A proposed scene.

    Attributes:
        draft: what stands in it.
        found: the body in the depth image of the first recording.
        calibration: at the end of the last fit of its place.
        inputs: the recordings, under a scene without placement.
        notes: what was read, in sentences.
        doubts: what a person should check, in sentences.
    """

    draft: Draft
    found: FoundBody
    calibration: Calibration
    inputs: OfflineInputs
    notes: tuple[str, ...]
    doubts: tuple[str, ...]


def propose(
    mesh_file: Path,
    bags: Sequence[Path],
    known: Question,
    *,
    ask_unit: Callable[[str, Sequence[str]], str | None] = lambda question, units: None,
    tell: Tell = lambda _: None,
) -> Proposal:
    """Propose a scene for recordings of a body at rest.

    Args:
        mesh_file: volume mesh, or a closed surface.
        bags: recordings of one posture.
        known: what a person says.
        ask_unit: asks for the mesh's unit, a question and answers to choose of; returns None
            where nobody can be asked.
        tell: told what is being done.

    Raises:
        InputError: when a file cannot be used, the unit is not known, or nothing in the image
            looks like the body.
    """
    tell('reading the recordings')
    recording = open_recording(bags[0], depth_topic=known.depth_topic)
    in_file = read_mesh(mesh_file, unit='m')
    unit, unit_doubt = _unit(mesh_file, in_file.mesh, recording, known, ask_unit)
    draft = _first_draft(mesh_file, unit, bags, known, in_file.mesh)
    inputs = _inputs(draft, known)
    observation = inputs.observations[0]
    gravity = gravity_of(recording, observation, known.gravity, known.marker, known.pose_frame)
    draft = replace(draft, gravity=gravity.vector)
    scene = _with_gravity(inputs.scene, gravity)
    if known.fixture is None:
        found = find_body(scene, observation, pixel=known.pixel, tell=tell)
    else:
        tell('fitting the body where the fixture holds it')
        found = body_in_fixture(scene, observation)
    if found is None or found.merit < _LEAST_MERIT:
        raise InputError(
            f'nothing in {bags[0]} looks like {mesh_file.name} hanging from a clamp at one of its '
            f'ends: check that it is in view, that {unit} is the unit of the mesh (--unit), and '
            'where gravity points (--gravity), or name a pixel on it (--at COLUMN,ROW)'
        )
    if found.fit.calibration is None:
        raise InputError(
            f'{mesh_file.name} was found in {bags[0]}, but cannot be simulated there with '
            'quadratic elements: improve the mesh, and see that it is held by more than a corner'
        )
    draft, doubts = _finished(draft, scene, found, gravity, unit_doubt, known, observation.camera)
    notes = (*in_file.notes, *inputs.notes)
    return Proposal(draft, found, found.fit.calibration, inputs, notes, doubts)


def _unit(
    mesh_file: Path,
    mesh: TetMesh,
    recording: Recording,
    known: Question,
    ask: Callable[[str, Sequence[str]], str | None],
) -> tuple[str, str]:
    """Return the unit of a mesh, and what to check about it or nothing."""
    if known.unit is not None:
        return known.unit, ''
    size = float(np.ptp(mesh.rest_positions, axis=0).max())
    frame = next(iter(recording.depth_frames(limit=1)))
    units = fitting_units(size, frame.depth, recording.depth_camera)
    if len(units) == 1:
        return units[0], ''
    question = (
        f'{mesh_file.name} is {size:.4g} units long: {sizes(size)}; the camera sees '
        f'{"nothing of that size" if not units else "things of several of these sizes"}'
    )
    answer = ask(question, units)
    if answer is None:
        raise InputError(f'{question}: say which unit it has with --unit')
    return answer, f'the unit {answer} of the mesh is as was answered'


def _first_draft(
    mesh_file: Path, unit: str, bags: Sequence[Path], known: Question, mesh: TetMesh
) -> Draft:
    """Return a draft that can be read, with nothing in its place yet."""
    scaled = read_mesh(mesh_file, unit=unit).mesh
    hold = possible_holds(scaled)[0]
    return Draft(
        name=mesh_file.stem,
        mesh_file=mesh_file,
        unit=unit,
        bags=tuple(bags),
        gravity=_first_gravity(known),
        world_from_object=np.eye(4),
        hold=hold,
        held=hold.vertices(scaled),
        youngs_modulus=_ANY_MODULUS,
        density=SILICONE_DENSITY if known.density is None else known.density,
        poissons_ratio=SILICONE_RATIO if known.poissons_ratio is None else known.poissons_ratio,
        marker=known.marker,
        pose_frame=known.pose_frame,
        sensor=known.sensor,
        fixture_file=known.fixture,
    )


def _first_gravity(known: Question) -> FloatArray:
    """Return gravity before any is read; none where it would tell how a fixture stands."""
    if known.fixture is None:
        return np.array([0.0, -9.81, 0.0])
    return np.zeros(3) if known.gravity is None else np.array(known.gravity)


def _inputs(draft: Draft, known: Question) -> OfflineInputs:
    """Read the recordings as a calibration does."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / 'scene.yaml'
        path.write_text(draft.text(Path(folder)))
        try:
            scene = load_scene(path)
        except SceneError as error:
            raise InputError(str(error).replace(str(path), 'the proposed scene')) from error
        return open_inputs(scene, (), depth_topic=known.depth_topic)


def _with_gravity(scene: Scene, gravity: Gravity) -> Scene:
    setups = tuple(replace(setup, gravity=gravity.vector) for setup in scene.observations)
    return replace(scene, observations=setups)


def _finished(
    draft: Draft,
    scene: Scene,
    found: FoundBody,
    gravity: Gravity,
    unit_doubt: str,
    known: Question,
    camera: PinholeCamera,
) -> tuple[Draft, tuple[str, ...]]:
    """Put what was found into the draft, and say what is not sure."""
    fit = found.fit
    hold = fit.hold
    if fit.clamp.is_seen:
        hold = hold.moved(fit.clamp.plane).at_row(scene.mesh, fit.clamp.doubt)
    held = hold.vertices(scene.mesh)
    pivot = scene.mesh.rest_positions[held].mean(axis=0)
    if known.fixture is None:
        level = level_placement(fit.world_from_object, hold.direction, gravity.vector, pivot)
    else:
        level = np.eye(4)
    turned = 0.0 if known.fixture else float(np.rad2deg(tilt(fit.world_from_object, level)))
    doubts: dict[str, list[str]] = {'gravity': list(gravity.doubts)}
    if unit_doubt:
        doubts['mesh'] = [unit_doubt]
    doubts['placement'] = _placement_doubts(found, turned, camera)
    if known.fixture is not None:
        doubts['placement'] += _seat_doubts(fit.world_from_object, pivot)
    doubts['held'] = _clamp_doubts(found, scene.mesh)
    doubts['regions'] = _material_doubts(known)
    remarks = {
        key: tuple(f'check: {text}.' for text in texts) for key, texts in doubts.items() if texts
    }
    length = 1e3 * float(np.ptp(scene.mesh.rest_positions, axis=0).max())
    remarks['mesh'] = (f'The body is {length:.4g} mm long.', *remarks.get('mesh', ()))
    where = 'found in the depth image.'
    if known.fixture is not None:
        where = 'the world is the frame of mesh and fixture; gravity stands in it as well.'
    remarks['placement'] = (
        f'world_from_object [m]: {where}',
        *remarks.get('placement', ()),
    )
    draft = replace(
        draft,
        world_from_object=level,
        hold=hold,
        held=held,
        youngs_modulus=fit.youngs_modulus,
        remarks=remarks,
    )
    return draft, tuple(text for texts in doubts.values() for text in texts)


def _placement_doubts(found: FoundBody, turned: float, camera: PinholeCamera) -> list[str]:
    doubts = []
    if turned > 0.5:
        doubts.append(
            f'the body is taken to be clamped level; the depth image alone would turn it by '
            f'{turned:.1f} degrees'
        )
    for merit, middle in found.rivals[:3]:
        column, row = camera.project(middle)
        doubts.append(
            f'a place about column {column:.0f}, row {row:.0f} of the depth image looks '
            f'nearly as good (merit {merit:.2f}, this one {found.merit:.2f}): say where the body '
            'is with --at'
        )
    gap = found.fit.result.gap_end
    if gap.coverage_in_sight < 0.9 or gap.explained < 0.9 or gap.median > 0.003:
        doubts.append(
            f'what is proposed leaves a gap of {1e3 * gap.median:.1f} mm, with '
            f'{100 * gap.coverage_in_sight:.0f} % of the body covered and '
            f'{100 * gap.explained:.0f} % explained'
        )
    return doubts


def _seat_doubts(fitted: FloatArray, pivot: FloatArray) -> list[str]:
    """Say where the image has the body elsewhere than the CAD of its clamp."""
    shift = 1e3 * float(np.linalg.norm(apply(fitted, pivot) - pivot))
    turn = float(np.rad2deg(angle_between(fitted, np.eye(4))))
    if shift <= _SEAT and turn <= _SEAT_TURN:
        return []
    return [
        f'in the image the held part is {shift:.1f} mm and {turn:.1f} degrees from where mesh and '
        'fixture have it; see that both are in one frame, and how the body sits in the clamp'
    ]


def _clamp_doubts(found: FoundBody, mesh: TetMesh) -> list[str]:
    clamp = found.fit.clamp
    if not clamp.is_seen:
        return [
            'nothing was seen to hide the body at its held end, so that where the clamp begins is '
            'a guess; measure how much of the body it holds'
        ]
    doubts = []
    free = clamp.plane - float((mesh.rest_positions @ found.fit.hold.direction).min())
    share = _MODULUS_POWER * clamp.doubt / free
    if clamp.doubt > _SURE or share > _MODULUS_SURE:
        doubts.append(
            f'the clamp may begin {1e3 * clamp.doubt:.0f} mm nearer or farther, and the modulus '
            f'be about {100.0 * share:.0f} % lower or higher with that, beside the error that a '
            'fit states'
        )
    if clamp.is_oblique:
        doubts.append(
            'the camera looks from behind the front of the clamp, which may hide some of the free '
            'body as well'
        )
    return [*doubts, *_slide_doubts(found, mesh)]


def _slide_doubts(found: FoundBody, mesh: TetMesh) -> list[str]:
    """Say where else along itself the body fits nearly as well."""
    clamp, end = found.fit.clamp, float((mesh.rest_positions @ found.fit.hold.direction).max())
    held = [1e3 * (end - plane) for plane in found.slides]
    own = 1e3 * (end - clamp.plane)
    if all(abs(other - own) <= 1e3 * max(clamp.doubt, _SURE) for other in held):
        return []
    return [
        f'slid along itself the body fits nearly as well: {min([*held, own]):.0f} to '
        f'{max([*held, own]):.0f} mm of it may be held, where {own:.0f} are proposed, and the '
        'modulus goes with that; measure how much of it the clamp holds'
    ]


def _material_doubts(known: Question) -> list[str]:
    doubts = []
    if known.density is None:
        doubts.append(
            f'{SILICONE_DENSITY:g} kg/m^3 is the density of silicone; a modulus fitted at rest is '
            'proportional to it'
        )
    if known.poissons_ratio is None:
        doubts.append(f"{SILICONE_RATIO:g} is Poisson's ratio of rubbers")
    return doubts
