# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
import numpy as np

from benchmarks.blind.renderer import Camera, render
from benchmarks.blind.sensor import expose, scan, Sensor, smooth_field
from benchmarks.blind.surface import grid_triangles, Triangles

CAMERA = Camera(160, 120, 200.0, 210.0, 81.3, 57.8)
OFFSETS = (np.arange(3) + 0.5) / 3.0 - 0.5


def _rays(column: int, row: int, shape: tuple[int, ...]) -> np.ndarray:
    """Return the viewing ray of every sample, z = 1, shape (h, w, 9, 3)."""
    rows, columns = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing='ij')
    v = (row + rows)[..., None, None] + OFFSETS[:, None]
    u = (column + columns)[..., None, None] + OFFSETS[None, :]
    x = np.broadcast_to((u - CAMERA.cx) / CAMERA.fx, (*shape[:2], 3, 3))
    y = np.broadcast_to((v - CAMERA.cy) / CAMERA.fy, (*shape[:2], 3, 3))
    return np.stack([x, y, np.ones_like(x)], axis=-1).reshape(*shape[:2], 9, 3)


def test_plane_is_exact() -> None:
    corner, one, two = np.array([-0.04, -0.03, 0.3]), np.array([0.09, 0.01, 0.05]), None
    two = np.array([-0.01, 0.07, -0.03])
    points = np.array([corner, corner + one, corner + two, corner + one + two])
    surface = Triangles(points[[[0, 1, 2], [1, 3, 2]]], np.zeros(2, dtype=np.int64))
    view = render(surface, CAMERA)
    normal = np.cross(one, two)
    expected = (normal @ corner) / (_rays(view.column, view.row, view.depth.shape) @ normal)
    hit = np.isfinite(view.depth)
    area = 0.5 * np.abs(np.linalg.det(np.diff(CAMERA.project(points)[:3], axis=0)))
    assert hit.sum() > 8.0 * area
    # Perspective-correct interpolation is exact on a plane: rounding.
    assert np.abs(view.depth[hit] - expected[hit]).max() < 1e-12


def test_ellipsoid_agrees_with_its_equation() -> None:
    cuts = 120
    axes, center = np.array([0.04, 0.025, 0.03]), np.array([0.005, -0.004, 0.35])
    polar, azimuth = np.meshgrid(
        np.linspace(0, np.pi, cuts + 1), np.linspace(0, 2 * np.pi, cuts + 1), indexing='ij'
    )
    sphere = np.stack(
        [np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=-1
    ).reshape(-1, 3)
    corners = (center + axes * sphere)[grid_triangles(cuts)]
    view = render(Triangles(corners, np.zeros(len(corners), dtype=np.int64)), CAMERA)
    rays = _rays(view.column, view.row, view.depth.shape) / axes
    origin = -center / axes
    a, b, c = (rays**2).sum(-1), (rays @ origin), origin @ origin - 1.0
    discriminant = b**2 - a * c
    hit = np.isfinite(view.depth)
    # Chords of 3 degrees: the outline lies 0.03 % of the radius inside.
    assert (discriminant[hit] > 0.0).all()
    assert hit.sum() > 0.99 * (discriminant > 0.0).sum()
    clear = hit & (discriminant > 0.1 * discriminant.max())
    exact = (-b[clear] - np.sqrt(discriminant[clear])) / a[clear]
    assert np.abs(view.depth[clear] - exact).max() < 5e-5


def test_smooth_field_has_its_size_and_length() -> None:
    random = np.random.default_rng(5)
    fields = np.stack([smooth_field((200, 240), 40.0, random) for _ in range(60)])
    # 60 draws of some twenty independent spots each: a tenth at most.
    assert abs(fields.std() - 1.0) < 0.1
    correlation = (fields[:, :, :-40] * fields[:, :, 40:]).mean() / (fields**2).mean()
    assert abs(correlation - np.exp(-1.0)) < 0.1


def test_lidar_frames_scatter_by_their_noise_around_the_truth() -> None:
    corners = np.array([[[-0.2, -0.2, 0.4], [0.4, -0.2, 0.4], [-0.2, 0.4, 0.4]]])
    view = render(Triangles(corners, np.zeros(1, dtype=np.int64)), CAMERA)
    sensor = Sensor('lidar', 0.00014, 0.0, 0.00025, 0.0, 0.0, 80.0, 0.15)
    random = np.random.default_rng(6)
    seen = scan(view, CAMERA, sensor.wall)
    bias = np.zeros(seen.depth.shape)
    frames = np.stack([expose(seen, sensor, bias, random) for _ in range(20)])[:, 20:60, 20:60]
    steps = frames / sensor.step
    assert np.abs(steps - np.round(steps)).max() < 1e-3
    # A step of 0.25 mm adds its own variance, step^2 / 12.
    expected = np.hypot(sensor.noise, sensor.step / np.sqrt(12.0))
    assert abs(frames.std() / expected - 1.0) < 0.05
    assert abs(frames.mean() - 0.4) < 5e-6
