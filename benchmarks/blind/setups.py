# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Draw a set-up: body, material, camera and the poses in which it is filmed."""

from dataclasses import dataclass, field

import numpy as np

from benchmarks.blind.renderer import Camera
from benchmarks.blind.rotations import rigid, rotation
from benchmarks.blind.rubber import Rubber
from benchmarks.blind.sensor import lidar, Sensor, stereo
from benchmarks.blind.shapes import draw_shape, FloatArray, Shape

GRAVITY = 9.81  # [m/s^2], along -y of the world.
POSES = ('level', 'rolled', 'pitched', 'inverted')
_FIXTURE_RIM = 0.004  # By which the clamp's jaws stand out beyond the body [m].


@dataclass(frozen=True)
class Observation:
    """One pose.

    Attributes:
        name: one of `POSES`.
        world_from_object: placement of the body, shape (4, 4).
        stated: what the scene says of it, where that is off; None: the same.
    """

    name: str
    world_from_object: FloatArray
    stated: FloatArray | None = None


@dataclass(frozen=True)
class Setup:
    """All that is known about a rig, and its true modulus.

    Attributes:
        shape: the body.
        youngs_modulus: true one [Pa].
        start_modulus: where a fit may start [Pa].
        poissons_ratio: known.
        density: known [kg/m^3].
        camera: stated intrinsics.
        depth_from_world: stated camera pose, shape (4, 4).
        sensor: kind and size of its errors.
        observations: poses.
        pose_errors: standard deviations of position [m] and rotation [deg] that the scene states.
        rubber: what the body is made of.
        fixture_shift: of the stated fixture from the true one, object frame [m].
        frames: of each pose.
    """

    shape: Shape
    youngs_modulus: float
    start_modulus: float
    poissons_ratio: float
    density: float
    camera: Camera
    depth_from_world: FloatArray
    sensor: Sensor
    observations: tuple[Observation, ...]
    pose_errors: tuple[float, float] = (0.0, 0.0)
    rubber: Rubber = field(default_factory=Rubber)
    fixture_shift: tuple[float, float, float] = (0.0, 0.0, 0.0)
    frames: int = 8

    @property
    def fixture(self) -> tuple[FloatArray, FloatArray]:
        """Lowest and highest corner of the rigid block that hides the clamp, object frame [m]."""
        shape = self.shape
        width, height = shape.section
        half = np.array([0.5 * width, 0.5 * height]) + _FIXTURE_RIM
        return (
            np.array([-_FIXTURE_RIM, *-half]),
            np.array([shape.clamp - 0.001, *half]),
        )

    @property
    def fixtures(self) -> tuple[tuple[FloatArray, FloatArray], ...]:
        """The blocks of all clamps of the rig."""
        return (self.fixture,)

    @property
    def stated_fixture(self) -> tuple[FloatArray, FloatArray]:
        """The same as the scene states it."""
        low, high = self.fixture
        shift = np.array(self.fixture_shift)
        return low + shift, high + shift

    def pose_number(self, observation: Observation) -> int:
        """Return which of the poses one is, from 0."""
        return [other.name for other in self.observations].index(observation.name)

    def reached(self, observation: Observation) -> float:
        """Return how far the recording has come by a pose: a quarter to 1 where there are four."""
        return (1.0 + self.pose_number(observation)) / len(self.observations)


def draw_setup(family: str, *, is_sealed: bool, poses: int, random: np.random.Generator) -> Setup:
    """Draw a set-up.

    Args:
        family: of the shape.
        is_sealed: draw materials from the range of the sealed set.
        poses: 1 or 4.
        random: source.
    """
    shape = draw_shape(family, random)
    density = random.uniform(1120.0, 1210.0) if is_sealed else random.uniform(1040.0, 1110.0)
    poissons_ratio = float(random.choice([0.48, 0.49, 0.493] if is_sealed else [0.47, 0.49]))
    modulus = _modulus(shape, density, random)
    distance = random.uniform(0.31, 0.37)
    bias = random.uniform(0.0001, 0.0002)
    is_stereo = random.random() < 0.25
    sensor = stereo(bias, distance) if is_stereo else lidar(bias)
    focal = random.uniform(560.0, 640.0)
    camera = Camera(
        width=640,
        height=480,
        fx=focal,
        fy=focal * random.uniform(0.995, 1.005),
        cx=319.5 + random.uniform(-6.0, 6.0),
        cy=239.5 + random.uniform(-6.0, 6.0),
    )
    return Setup(
        shape=shape,
        youngs_modulus=modulus,
        start_modulus=float(f'{modulus * np.exp(random.uniform(-0.35, 0.35)):.4g}'),
        poissons_ratio=poissons_ratio,
        density=float(f'{density:.5g}'),
        camera=camera,
        depth_from_world=_look(distance, random),
        sensor=sensor,
        observations=tuple(_observations(shape, poses, random)),
    )


def _modulus(shape: Shape, density: float, random: np.random.Generator) -> float:
    """Choose E so that the body sags by a visible share of its length."""
    is_branched = shape.family in ('hook', 'tee')
    sag = random.uniform(0.05, 0.10) if is_branched else random.uniform(0.09, 0.24)
    free = shape.length - shape.clamp
    height = min(shape.section)
    return float(1.5 * density * GRAVITY * free**3 / (height**2 * sag))


def _look(distance: float, random: np.random.Generator) -> FloatArray:
    """Return depth_from_world of a camera that looks at the origin, roughly along -z."""
    level = np.array([[1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]])
    turn = rotation(np.deg2rad([random.uniform(8.0, 22.0), random.uniform(-12.0, 12.0), 0.0]))
    roll = rotation(np.deg2rad([0.0, 0.0, random.uniform(-6.0, 6.0)]))
    return rigid(roll @ level @ turn, np.array([0.0, 0.0, distance]))


def _observations(shape: Shape, poses: int, random: np.random.Generator) -> list[Observation]:
    side = random.choice([-1.0, 1.0])
    # Object z points up, its x to the right or to the left of the image.
    base = np.array([[side, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -side, 0.0]])
    middle = np.array([0.5 * shape.length, 0.0, 0.0])
    rolls = {'level': 0.0, 'rolled': 90.0, 'pitched': 20.0, 'inverted': 180.0}
    pitches = {'level': 0.0, 'rolled': 0.0, 'pitched': -40.0, 'inverted': 25.0}
    # Lying flat, a plate would be seen edge on.
    slant = 30.0 if shape.family in ('plate', 'fin') else 0.0
    found = []
    for name in POSES[:poses]:
        roll = rolls[name] + slant + random.uniform(-8.0, 8.0)
        pitch = side * (pitches[name] + random.uniform(-6.0, 6.0))
        yaw = random.uniform(-18.0, 18.0)
        turned = rotation(np.deg2rad([0.0, yaw, 0.0])) @ rotation(np.deg2rad([0.0, 0.0, pitch]))
        matrix = turned @ base @ rotation(np.deg2rad([roll, 0.0, 0.0]))
        # Different distances tell a scale of depth from an offset.
        target = np.array(
            [random.uniform(-0.01, 0.01), random.uniform(0.0, 0.02), random.uniform(-0.045, 0.045)]
        )
        found.append(Observation(name, rigid(matrix, target - matrix @ middle)))
    return found
