# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Run MuJoCo until a body is at rest, or at given times after it was let go."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

from diffcal_ros.export.exported_body import ExportedBody
from diffcal_ros.export.targets.mjcf import mjcf
from diffcal_ros.fem.motion.inputs import MotionError
from diffcal_ros.fem.statics.equilibrium import EquilibriumError
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]

# Rayleigh's factor while a rest is sought, near the critical one of bodies that sag by
# centimetres [s]; where the rest is does not depend on it.
_DAMPING = 0.05
# A body is at rest when no vertex has moved further than this [m] from where it is ...
_STILL = 1e-6
_STEPS = 20  # ... during so many steps.
_LONGEST = 20.0  # Simulated time after which it is given up [s].


def come_to_rest(body: ExportedBody, start: FloatArray) -> FloatArray:
    """Return where MuJoCo's vertices come to rest; see `simulators.Run`.

    Args:
        body: to be simulated.
        start: vertices where the simulation begins [m], shape (V, 3).

    Raises:
        EquilibriumError: when they move on for 20 s.
    """
    import mujoco

    with _quiet(mujoco):
        model, data = _begin(mujoco, _damped(body), start)
        positions = _vertices(data)
        while data.time < _LONGEST:
            path = []
            for _ in range(_STEPS):
                mujoco.mj_step(model, data)
                path.append(data.qpos.copy())
            positions = _vertices(data)
            if np.abs(np.array(path) - path[-1]).max() < _STILL:
                return positions
    raise EquilibriumError(
        f'MuJoCo did not come to rest within {_LONGEST:g} s of simulated time: '
        f'{np.abs(np.array(path) - path[-1]).max():.2g} m were moved in the last {_STEPS} steps'
    )


def swing(body: ExportedBody, start: FloatArray, times: FloatArray) -> FloatArray:
    """Return where MuJoCo's vertices are at some times, shape (S, V, 3); see `simulators.Swing`.

    Steps and damping are those of the file that is exported. Between two steps the way is taken
    to be straight.

    Args:
        body: to be simulated.
        start: vertices where it is let go [m], shape (V, 3).
        times: since then [s], ascending, shape (S,).

    Raises:
        MotionError: when it falls apart.
    """
    import mujoco

    frames = np.empty((len(times), *start.shape))
    with _quiet(mujoco):
        model, data = _begin(mujoco, body, start)
        before, after = _vertices(data), _vertices(data)
        step = float(model.opt.timestep)
        for frame, time in zip(frames, times, strict=True):
            while data.time < time:
                mujoco.mj_step(model, data)
                # A step ends with velocities and slides; where bodies are then follows from them.
                mujoco.mj_kinematics(model, data)
                before, after = after, _vertices(data)
            frame[:] = after + (before - after) * ((data.time - time) / step)
    if not np.isfinite(frames).all():
        raise MotionError('MuJoCo: the body fell apart after it was let go')
    return frames


def _begin(mujoco: Any, body: ExportedBody, start: FloatArray) -> tuple[Any, Any]:
    """Return the model and its state with the vertices where the simulation begins."""
    model = mujoco.MjModel.from_xml_string(mjcf(body))
    data = mujoco.MjData(model)
    free = np.ones(body.mesh.vertex_count, dtype=bool)
    free[body.held] = False
    # The vertices' bodies come in their order, the free ones with three slides each.
    data.qpos[:] = (start - body.mesh.rest_positions)[free].reshape(-1)
    mujoco.mj_forward(model, data)
    return model, data


def _damped(body: ExportedBody) -> ExportedBody:
    return replace(body, damping=_DAMPING * body.damping_of_stiffness)


def _vertices(data: Any) -> FloatArray:
    """Return the bodies that carry vertices, all but the world [m], shape (V, 3)."""
    return np.array(data.xpos[1:])


@contextmanager
def _quiet(mujoco: Any) -> Iterator[None]:
    """Keep MuJoCo from writing a log file: what matters is whether the body comes to rest."""
    before = mujoco.get_mju_user_warning()
    mujoco.set_mju_user_warning(lambda text: None)
    try:
        yield
    finally:
        mujoco.set_mju_user_warning(before)
