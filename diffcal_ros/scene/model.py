# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What a calibration needs to know about the set-up, resolved and in SI units.

Frames: `object` is the mesh's own, `world` that of the rig (the marker's, unless the scene says
otherwise), `depth` and `color` the optical frames of the camera.
"""

from dataclasses import dataclass, field
import math
from pathlib import Path
from typing import Any

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.laws import USUAL_LAW
from diffcal_ros.marker import Marker
from diffcal_ros.material import LameConvention
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

# Names of the integrator that leaves inertia out, and of the one of explicit steps.
QUASI_STATIC, SEMI_IMPLICIT = 'quasi_static', 'semi_implicit'
# Where the camera's pose may come from: the marker in the colour images, the scene itself, TF, a
# topic, or the fixture in the depth images.
POSE_SOURCES = ('marker', 'stored', 'tf', 'topic', 'fixture')
# How well a pose is known where nobody says: as by a careful hand-eye calibration [m], [rad].
USUAL_POSITION_STD = 0.001
USUAL_ROTATION_STD = float(np.deg2rad(0.3))
FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class Quantity:
    """A number that may be fitted.

    Attributes:
        start: where a fit starts; the value where it is not fitted.
        lower: smallest value a fit may take.
        upper: largest value a fit may take.
        prior_mean: what is known beforehand, or None.
        prior_std: its standard deviation, in the same unit; None without a prior.
    """

    start: float
    lower: float
    upper: float
    prior_mean: float | None = None
    prior_std: float | None = None


@dataclass(frozen=True)
class Region:
    """A part of the body with one material.

    Attributes:
        name: as in the scene file.
        tets: its tetrahedra, shape (t,).
        youngs_modulus: [Pa].
        poissons_ratio: dimensionless.
        density: [kg/m^3].
        damping: by which the material resists strain rates [Pa s], or None for none.
    """

    name: str
    tets: IntArray
    youngs_modulus: Quantity
    poissons_ratio: Quantity
    density: Quantity
    damping: Quantity | None = None


@dataclass(frozen=True)
class Turn:
    """A rotation of held vertices, done in quasi-static steps.

    Attributes:
        axis: unit direction in the world frame, shape (3,).
        center: a point on the axis in the world frame [m], shape (3,); None for the middle of
            the held part's bounding box.
        angle: [rad]; may exceed one turn.
        translation: afterwards, in the world frame [m], shape (3,).
    """

    axis: FloatArray
    angle: float
    center: FloatArray | None = None
    translation: FloatArray = field(default_factory=lambda: np.zeros(3))


@dataclass(frozen=True)
class HeldPart:
    """Vertices that a clamp holds.

    Attributes:
        name: as in the scene file.
        vertices: mesh vertices, shape (h,).
        turn: how the clamp moves from the rest shape to the observed pose; None: it stays.
    """

    name: str
    vertices: IntArray
    turn: Turn | None = None


@dataclass(frozen=True)
class Cable:
    """A cable that runs through the body without friction, and only pulls.

    Attributes:
        name: as in the scene file.
        via_points: from one end to the other, object frame [m], shape (n, 3); both ends are fixed
            to the material around them.
        rest_length: beyond which it pulls [m]; what an observation pulls comes off it.
        stiffness: pull per stretch [N/m].
    """

    name: str
    via_points: FloatArray
    rest_length: Quantity
    stiffness: Quantity

    @property
    def length(self) -> float:
        """Its length through the body at rest [m]."""
        return float(np.linalg.norm(np.diff(self.via_points, axis=0), axis=1).sum())


@dataclass(frozen=True)
class MotionSetup:
    """A body that rests until parts of its clamp let go, and what is filmed of its motion.

    Attributes:
        released: names of the held parts that let go, all at once.
        release_time: when, after the first frame [s].
        integrator: name of the time integrator.
        time_step: longest step [s]; None for the integrator's own.
        tolerance: what a step of `implicit` may be off by [m], which chooses the steps; None for
            fixed ones.
        duration: how much of the recording is used, from its first frame [s]; None for all.
        most_frames: at most so many frames are compared, evenly spaced.
        hold_out: one frame in as many is kept from the fit and only compared; 0 for none.
    """

    released: tuple[str, ...]
    release_time: Quantity
    integrator: str = 'implicit'
    time_step: float | None = None
    duration: float | None = None
    most_frames: int = 60
    hold_out: int = 5
    tolerance: float | None = None

    @property
    def is_slow(self) -> bool:
        """Tell whether the body is at rest in every frame, and only creeps."""
        return self.integrator == QUASI_STATIC

    @property
    def has_explicit_steps(self) -> bool:
        """Tell whether each step goes by what acts at its begin alone."""
        return self.integrator == SEMI_IMPLICIT


@dataclass(frozen=True)
class Masks:
    """Pixels that a fit leaves out.

    Attributes:
        held: leave out the held part, which the clamp hides.
        held_margin: and the surface within this distance of it [m].
        boxes: image boxes (u0, v0, u1, v1), inclusive [px].
        silhouette_band: leave depth out this close to an outline [px]: flying pixels.
        grazing_angle: leave depth out where the surface is seen at a flatter angle, measured
            from its normal [rad].
        truncation: residuals beyond this are not the body [m].
    """

    held: bool = True
    held_margin: float = 0.0
    boxes: tuple[tuple[int, int, int, int], ...] = ()
    silhouette_band: float = 3.0
    grazing_angle: float = np.deg2rad(75.0)
    truncation: float = 0.02


@dataclass(frozen=True)
class DepthSensor:
    """What is known about the depth camera.

    Attributes:
        noise: standard deviation of one pixel's depth [m].
        quantization: step of the depth values [m]; 0 for none.
        quantization_mode: 'round', or 'truncate' (the RealSense ROS driver's 16UC1, which is low
            by half a step on average).
        model: name of a camera in `depth_sensors`, whose noise grows with distance; empty where
            `noise` is stated.
        nearest: depth below it is no measurement [m].
        farthest: depth beyond it is no measurement [m].
        driver_step: images in whole steps of this [m] were cut by the camera's ROS driver; 0 where
            that is not so, or the scene states the steps.
        smooth_error: standard deviation of an error of depth that is smooth over the image and
            does not change with time [m]; 0: as is usual.
    """

    noise: float = 0.00014
    quantization: float = 0.00025
    quantization_mode: str = 'round'
    model: str = ''
    nearest: float = 0.0
    farthest: float = math.inf
    driver_step: float = 0.0
    smooth_error: float = 0.0


@dataclass(frozen=True)
class Fixture:
    """A rigid part of the rig that cameras see beside the body: no load moves it.

    Attributes:
        positions: object frame [m], shape (V, 3); it goes where an observation places the body.
        triangles: outward, shape (F, 3).
    """

    positions: FloatArray
    triangles: IntArray


@dataclass(frozen=True)
class RigidOffset:
    """Prior of a rigid offset between camera and rig.

    Attributes:
        translation_std: [m].
        rotation_std: [rad].
        each_recording: every recording has its own; else all share one.
    """

    translation_std: float = 0.020
    rotation_std: float = np.deg2rad(5.0)
    each_recording: bool = False

    @property
    def covariance(self) -> FloatArray:
        """Of a shift [m] and a turn [rad], shape (6, 6)."""
        return np.diag([self.translation_std**2] * 3 + [self.rotation_std**2] * 3)


@dataclass(frozen=True)
class PoseSetup:
    """Where the camera's pose comes from, and how well it is known where nothing measures that.

    Attributes:
        source: one of `POSE_SOURCES`, or empty where the scene does not say.
        world_frame: TF's name of the scene's world frame; empty where it has none.
        topic: with poses; empty for the only one of a recording, and live for `marker_pose/pose`.
        position_std: standard deviation of the camera's position along each axis [m]; None where
            the scene does not say. With `rotation_std` zero: the pose is exact.
        rotation_std: of the camera's direction about each of its axes [rad]; None likewise.
    """

    source: str = ''
    world_frame: str = ''
    topic: str = ''
    position_std: float | None = None
    rotation_std: float | None = None

    def __post_init__(self) -> None:
        position, rotation = self.spread
        if min(position, rotation) < 0.0 or (position == 0.0) != (rotation == 0.0):
            raise ValueError(
                f'position_std is {position:g} m and rotation_std {rotation:g} rad: give two '
                'positive numbers, or 0 for both where the pose is exact'
            )

    @property
    def spread(self) -> tuple[float, float]:
        """Standard deviations in force, of position [m] and direction [rad]."""
        return (
            USUAL_POSITION_STD if self.position_std is None else self.position_std,
            USUAL_ROTATION_STD if self.rotation_std is None else self.rotation_std,
        )

    @property
    def is_spread_stated(self) -> bool:
        """Tell whether the scene says how well the pose is known."""
        return self.position_std is not None and self.rotation_std is not None


@dataclass(frozen=True)
class ObservationSetup:
    """One way the body is posed; a calibration takes several that share parameters.

    Attributes:
        name: as in the scene file.
        bag: its recording, or None where the command line names it.
        world_from_object: placement of the mesh, shape (4, 4).
        gravity: acceleration in the world frame [m/s^2], shape (3,).
        held: clamped parts.
        stored_depth_from_world: a camera pose given beforehand, shape (4, 4), or None.
        motion: how the body moves; None: it is at rest in every frame.
        pulls: by how much cables are shortened here, by name [m].
        pose: where the camera's pose comes from, and how well it is known.
    """

    name: str
    world_from_object: FloatArray
    gravity: FloatArray
    held: tuple[HeldPart, ...]
    bag: Path | None = None
    stored_depth_from_world: FloatArray | None = None
    motion: MotionSetup | None = None
    pulls: dict[str, float] = field(default_factory=dict)
    pose: PoseSetup = field(default_factory=PoseSetup)

    @property
    def staying(self) -> tuple[HeldPart, ...]:
        """Held parts that never let go."""
        released = () if self.motion is None else self.motion.released
        return tuple(part for part in self.held if part.name not in released)


@dataclass(frozen=True)
class Scene:
    """A whole set-up.

    Attributes:
        name: for titles.
        mesh: the body at rest, object frame.
        element: finite element on that mesh.
        regions: cover every tetrahedron exactly once.
        convention: how Young's modulus enters the energy.
        observations: at least one.
        fit: names of the parameters to fit, see `calibration.parameters`.
        law: name of the energy law, see `fem.laws`.
        marker: None when the pose comes from elsewhere.
        depth_camera: overrides camera_info when given.
        color_camera: likewise.
        masks: pixels to leave out.
        sensor: the depth camera's noise.
        rigid_offset: prior of the rigid offset.
        fixture: rigid part of the rig in view, or None.
        effects: amplitudes and settings of effects that were added to the model, SI units, by
            identifier and component; see `effects`.
        cables: that run through the body.
        relative_modulus: Young's modulus of each tetrahedron over its region's, shape (T,); None:
            1 everywhere.
        path: the scene file, or None when built in memory.
        document: the file's content, for writing a fitted copy.
        notes: what reading changed or found worth telling, in sentences for the user.
    """

    name: str
    mesh: TetMesh
    element: Element
    regions: tuple[Region, ...]
    convention: LameConvention
    observations: tuple[ObservationSetup, ...]
    fit: tuple[str, ...]
    law: str = USUAL_LAW
    marker: Marker | None = None
    depth_camera: PinholeCamera | None = None
    color_camera: PinholeCamera | None = None
    masks: Masks = field(default_factory=Masks)
    sensor: DepthSensor = field(default_factory=DepthSensor)
    rigid_offset: RigidOffset = field(default_factory=RigidOffset)
    fixture: Fixture | None = None
    effects: dict[str, dict[str, float]] = field(default_factory=dict)
    cables: tuple[Cable, ...] = ()
    relative_modulus: FloatArray | None = None
    path: Path | None = None
    document: dict[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    def file_of(self, key: str) -> Path | None:
        """Return the file that a section of the scene file names, such as `mesh`, or None."""
        section = self.document.get(key)
        if self.path is None or section is None:
            return None
        return self.path.parent / Path(str(section['file'])).expanduser()
