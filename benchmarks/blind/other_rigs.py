# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Rigs for bodies of other kinds: other cameras, distances, poses and clamps.

Nothing is a fixed length: what a camera sees, how a body sags and how wide clamps are goes with
its size.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np
from scipy.spatial.transform import Rotation

from benchmarks.blind.equilibrium import NoEquilibriumError
from benchmarks.blind.faults import Faults
from benchmarks.blind.forms import off_the_truth
from benchmarks.blind.other_bodies import draw_other_shape, OtherShape
from benchmarks.blind.other_ranges import Ranges, RANGES_34
from benchmarks.blind.renderer import Camera
from benchmarks.blind.rotations import applied, rigid, rotation
from benchmarks.blind.rubber import draw_rubber
from benchmarks.blind.sensor import Sensor
from benchmarks.blind.setups import GRAVITY, Observation, Setup
from benchmarks.blind.shapes import FloatArray
from benchmarks.blind.simulation import make_specimen, settle
from benchmarks.blind.specimen import Specimen

COARSE = 0.8  # Refinement of bodies by which rigs and sizes of effects are found.
# Least share of the image's height for what is twenty times as long as thick.
_WHIP_FILLED = 0.7
_USUAL = 0.34  # At which sensors are as they are drawn [m].
# Power of the distance by which the noise of sensors grows.
_NOISE_POWERS = {'l515': 1.0, 'd405': 2.0, 'itof': 1.0}
_LEAST_NOISE = 0.00004  # [m].
_APART = 60.0  # Least angle between two orientations, as gravity has it [deg].
_STEEPEST = 0.87  # Sine of how far a body may point up; beyond, a slender one may buckle.
_END_ON = 0.75  # Cosine between where a body points and the line of sight, at most.
_EDGE_ON = 0.4  # The same of a flat one's thin way, at least.
_BORDER = 0.03  # Of the image's height, around what is seen.


class UnfitError(RuntimeError):
    """What was drawn cannot be filmed, or does not rest; the next draw may."""


@dataclass(frozen=True)
class OtherSetup(Setup):
    """A rig whose clamps and frames are not those of all other ones.

    Attributes:
        sag: largest way of any part by its weight, in all poses [m].
        smooth_stated: what the scene says of the sensor's smooth error [m]; None: nothing.
        changes: largest change of what is seen by each effect [m].
    """

    sag: float = 0.0
    smooth_stated: float | None = None
    changes: tuple[float, ...] = ()

    @property
    def body(self) -> OtherShape:
        """The body as what it is."""
        assert isinstance(self.shape, OtherShape)
        return self.shape

    @property
    def rim(self) -> float:
        """By how much jaws stand out beyond the body [m]."""
        return float(np.clip(0.035 * self.body.size, 0.0015, 0.006))

    @property
    def fixtures(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """Lowest and highest corner of the rigid block around each clamp, object frame [m]."""
        found, inset = [], 0.25 * self.rim
        for box in self.body.held:
            low, high = np.array(box).T
            low, high = low - self.rim, high + self.rim
            # Jaws end a little before what is held does, where the body goes on.
            for axis in (0, 1):
                if self.body.goes_on(box, axis, -1):
                    low[axis] = box[axis][0] + inset
                if self.body.goes_on(box, axis, 1):
                    high[axis] = box[axis][1] - inset
            found.append((low, high))
        return tuple(found)

    @property
    def fixture(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner around all clamps, object frame [m]."""
        lows, highs = zip(*self.fixtures, strict=True)
        return np.min(lows, axis=0), np.max(highs, axis=0)


def draw_other_setup(
    family: str,
    *,
    poses: int,
    sensor: str,
    law: str,
    random: np.random.Generator,
    is_lower: bool = False,
    sags_more: bool = False,
    ranges: Ranges = RANGES_34,
) -> OtherSetup:
    """Draw a rig.

    Args:
        family: of the body.
        poses: number of them.
        sensor: one of `sensor.DRAWN`.
        law: of the rubber.
        random: source.
        is_lower: whether the body is about level in the first pose.
        sags_more: whether it sags by no less than what is amid the possible, by its logarithm.
        ranges: of the set.

    Raises:
        UnfitError: where that cannot be filmed or does not rest.
    """
    kind = ranges.families[family]
    shape = draw_other_shape(family, random, ranges.families)
    least, most = np.log(kind.sags)
    wanted = float(np.exp(random.uniform(0.5 * (least + most) if sags_more else least, most)))
    views = [Observation(f'pose_{i + 1}', np.eye(4)) for i in range(poses)]
    setup = OtherSetup(
        shape=shape,
        youngs_modulus=30.0 * 1e3 * GRAVITY * shape.free**3 / min(shape.section) ** 2,
        start_modulus=1.0,
        poissons_ratio=round(float(random.uniform(0.45, 0.495)), 4),
        density=float(f'{random.uniform(950.0, 1300.0):.5g}'),
        camera=_draw_camera(family, ranges, random),
        depth_from_world=np.eye(4),
        sensor=Sensor('none', 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0),
        observations=tuple(views),
        rubber=draw_rubber(law, random),
        frames=int(random.integers(ranges.frames[0], ranges.frames[1] + 1)),
    )
    look = _draw_look(random)
    turns = _draw_turns(poses, look[:3, :3], random, is_flat=kind.is_flat, is_lower=is_lower)
    views = [
        replace(view, world_from_object=rigid(turn, np.zeros(3)))
        for view, turn in zip(views, turns, strict=True)
    ]
    setup, rests = _sagging(replace(setup, observations=tuple(views)), wanted, ranges)
    start = setup.youngs_modulus * np.exp(random.uniform(-0.35, 0.35))
    setup = replace(setup, start_modulus=float(f'{start:.4g}'))
    setup = _before_camera(setup, look, rests, ranges, random)
    return _off(setup, sensor, ranges, random)


def _draw_camera(family: str, ranges: Ranges, random: np.random.Generator) -> Camera:
    sizes = list(ranges.images)[1:] if family == 'whip' else list(ranges.images)
    width, height = sizes[int(random.integers(len(sizes)))]
    focal = random.uniform(*ranges.images[width, height]) * width
    return Camera(
        width=width,
        height=height,
        fx=focal,
        fy=focal * random.uniform(0.995, 1.005),
        cx=0.5 * (width - 1) + 0.01 * width * random.uniform(-1.0, 1.0),
        cy=0.5 * (height - 1) + 0.01 * width * random.uniform(-1.0, 1.0),
    )


def _draw_look(random: np.random.Generator) -> FloatArray:
    """Draw how a camera looks roughly along the world's -z, shape (4, 4), its place aside."""
    level = np.diag([1.0, -1.0, -1.0])
    turn = rotation(np.deg2rad([random.uniform(0.0, 25.0), random.uniform(-20.0, 20.0), 0.0]))
    roll = rotation(np.deg2rad([0.0, 0.0, random.uniform(-10.0, 10.0)]))
    return rigid(roll @ level @ turn, np.zeros(3))


def _draw_turns(
    count: int,
    look: FloatArray,
    random: np.random.Generator,
    *,
    is_flat: bool,
    is_lower: bool,
) -> list[FloatArray]:
    """Draw orientations, alike in all ways but those in which little of a body would be seen."""
    sight = look[2]
    while True:
        found: list[FloatArray] = []
        while len(found) < count:
            turn = Rotation.random(rng=random).as_matrix()
            ahead, thin = turn[:, 0], turn[:, 2]
            if abs(ahead @ sight) > _END_ON or ahead[1] > _STEEPEST:
                continue
            if is_flat and abs(thin @ sight) < _EDGE_ON:
                continue
            if is_lower and not found and not -0.4 < ahead[1] < 0.2:
                continue
            found.append(turn)
        if widest(found) > _APART + 2.0:
            return found


def widest(turns: Sequence[FloatArray]) -> float:
    """Return the largest angle between where gravity goes in two orientations [deg]."""
    downs = np.array([turn[1] for turn in turns])
    return float(np.rad2deg(np.arccos(np.clip(downs @ downs.T, -1.0, 1.0))).max())


def _sagging(
    setup: OtherSetup, wanted: float, ranges: Ranges
) -> tuple[OtherSetup, list[FloatArray]]:
    """Choose E so that a body sags by a share of its free length; return where it rests, too."""
    free = setup.body.free
    for _ in range(9):
        try:
            specimen = make_specimen(setup, Faults(), COARSE)
            rests = rests_of(specimen, setup, Faults())
        except (NoEquilibriumError, ValueError) as error:
            raise UnfitError(str(error)) from error
        nodes = specimen.mesh.nodes
        sag = max(float(np.linalg.norm(rest - nodes, axis=1).max()) for rest in rests)
        ratio = sag / (free * wanted)
        if abs(ratio - 1.0) < 0.03:
            break
        # The more a body sags, the less it does so in proportion.
        setup = replace(setup, youngs_modulus=setup.youngs_modulus * ratio**1.1)
    least, most = ranges.moduli
    if abs(ratio - 1.0) > 0.1 or not least < setup.youngs_modulus < most:
        raise UnfitError(f'E is {setup.youngs_modulus:g} Pa for a sag of {ratio:g}')
    return replace(setup, sag=sag), rests


def rests_of(specimen: Specimen, setup: Setup, faults: Faults) -> list[FloatArray]:
    """Return where a body rests in each pose, object frame [m]."""
    return [settle(specimen, setup, view, faults) for view in setup.observations]


def _before_camera(
    setup: OtherSetup,
    look: FloatArray,
    rests: list[FloatArray],
    ranges: Ranges,
    random: np.random.Generator,
) -> OtherSetup:
    """Place a body before a camera that is as far away as lets it see all of it."""
    camera = setup.camera
    turned = [
        rest @ view.world_from_object[:3, :3].T
        for rest, view in zip(rests, setup.observations, strict=True)
    ]
    in_sight = [points @ look[:3, :3].T for points in turned]
    extent = max(float(np.ptp(points[:, :2], axis=0).max()) for points in in_sight)
    lowest = _WHIP_FILLED if setup.body.family == 'whip' else ranges.filled[0]
    fill = random.uniform(lowest, ranges.filled[1])
    distance = float(np.clip(camera.fy * extent / (fill * camera.height), *ranges.distances))
    places = [random.uniform(-1.0, 1.0, 3) * [0.03, 0.03, 0.1] for _ in turned]
    while distance <= ranges.distances[1]:
        views = tuple(
            replace(
                view,
                world_from_object=rigid(
                    view.world_from_object[:3, :3],
                    distance * place - 0.5 * (points.min(axis=0) + points.max(axis=0)),
                ),
            )
            for view, place, points in zip(setup.observations, places, turned, strict=True)
        )
        depth_from_world = rigid(look[:3, :3], np.array([0.0, 0.0, distance]))
        setup = replace(setup, observations=views, depth_from_world=depth_from_world)
        if sees_all(setup, rests, 0.06 * setup.body.free):
            return setup
        distance *= 1.04
    raise UnfitError('no camera sees all of it')


def sees_all(setup: Setup, rests: list[FloatArray], margin: float = 0.0) -> bool:
    """Tell whether a body is within the image in all poses.

    Args:
        setup: the rig.
        rests: where it is in each pose, object frame [m].
        margin: by how much farther any part may be [m].
    """
    camera = setup.camera
    for rest, view in zip(rests, setup.observations, strict=True):
        points = applied(setup.depth_from_world @ view.world_from_object, rest)
        if points[:, 2].min() < 0.05:
            return False
        pixels = camera.project(points)
        more = margin * camera.fx / points[:, 2].min() + _BORDER * camera.height
        if (pixels < more).any():
            return False
        if (pixels > np.array([camera.width, camera.height]) - 1.0 - more).any():
            return False
    return True


def at_distance(sensor: Sensor, distance: float, bias: float) -> Sensor:
    """Return a sensor with the noise and steps that it has at a distance [m].

    Args:
        sensor: as it is at 0.34 m.
        distance: of what it sees [m].
        bias: its smooth error [m].
    """
    far = distance / _USUAL
    step = sensor.step * far**2 if sensor.step_distance else sensor.step
    return replace(
        sensor,
        noise=max(sensor.noise * far ** _NOISE_POWERS[sensor.kind], _LEAST_NOISE),
        step=step,
        bias=bias,
        halo=sensor.halo * far,
        wall=distance + 0.4,
    )


def _off(setup: OtherSetup, name: str, ranges: Ranges, random: np.random.Generator) -> OtherSetup:
    """Give a rig its sensor and its errors of pose and fixture."""
    distance = float(setup.depth_from_world[2, 3])
    bias = float(np.exp(random.uniform(*np.log(ranges.smooth))))
    moved = off_the_truth(setup, name, random)
    stated, factors = None, ranges.misstated
    if random.random() < 0.5:
        # Where all factors are alike none is drawn.
        number = int(random.integers(len(factors))) if len(factors) > 1 else 0
        stated = ceil(1e5 * factors[number] * bias) / 1e5
    shift = np.zeros(3)
    if random.random() < 0.5:
        shift = 1e-3 * rotation(random.standard_normal(3) * 2.0) @ [1.0, 0.0, 0.0]
    x, y, z = (round(float(value), 7) for value in shift)
    return replace(
        setup,
        sensor=at_distance(moved.sensor, distance, bias),
        observations=moved.observations,
        pose_errors=moved.pose_errors,
        smooth_stated=stated,
        fixture_shift=(x, y, z),
    )


def stated_fixtures(setup: Setup) -> list[tuple[FloatArray, FloatArray]]:
    """Return the blocks of all clamps as the scene states them, object frame [m]."""
    shift = np.array(setup.fixture_shift)
    return [(low + shift, high + shift) for low, high in setup.fixtures]
