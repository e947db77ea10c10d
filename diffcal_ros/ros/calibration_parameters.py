# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Parameters of the calibration node."""

from diffcal_ros.calibration.observations.observation import MAX_FUSED_FRAMES
from diffcal_ros.calibration.settings import CalibrationSettings, LOSSES, OPTIMIZERS
from diffcal_ros.calibration.tracking.tracked import TrackerSettings
from diffcal_ros.live.inputs import POSE_SOURCES, SCENE
from diffcal_ros.live.session_settings import DEPTH_QUANTIZATIONS, REFITS, SessionSettings
from diffcal_ros.live.tracking import TrackingSettings
from diffcal_ros.ros.diagnostics import PERIOD
from diffcal_ros.ros.parameters import Setting, Values
from diffcal_ros.warp_runtime.device_array import require_device

SETTINGS = (
    Setting('autostart', True, 'configure and activate by itself at the start', is_read_only=True),
    Setting('scene', '', 'scene file: body, clamp, material, marker'),
    Setting('observation', '', "which of the scene's observations is in view; empty: the first"),
    Setting(
        'fit', '', "parameters to fit, with commas between them; empty: as the scene's `fit` says"
    ),
    Setting('loss', 'robust', 'what is minimised', choices=LOSSES),
    Setting('optimizer', 'gauss_newton', 'how it is minimised', choices=OPTIMIZERS),
    Setting('max_iterations', 0, 'accepted steps at most; 0: 30, for Adam 100', 0, 1000),
    Setting('mesh_error', True, 'add what a finer mesh would change to the standard errors'),
    Setting('device', 'cpu', 'Warp device, such as cpu or cuda:0'),
    Setting(
        'pose_source',
        SCENE,
        "the camera's pose: what the scene says under pose, or else estimated (scene); the "
        "marker's on marker_pose/pose, checked against the depth on it (estimated); another on "
        "that topic, or the one that the scene names: the camera's own where its frame_id is the "
        "scene's world_frame, else the world's (topic); from TF, from world_frame to the depth "
        "images (tf); the scene's (stored); from where the depth images show the scene's fixture "
        '(fixture)',
        choices=POSE_SOURCES,
    ),
    Setting(
        'depth_quantization',
        'scene',
        'how the driver rounds depth; truncate_millimetres: the 16UC1 of the RealSense driver, '
        'low by half a millimetre on average, which is put back',
        choices=tuple(DEPTH_QUANTIZATIONS),
    ),
    Setting(
        'window.frames', MAX_FUSED_FRAMES, 'frames that are fused into one', 1, MAX_FUSED_FRAMES
    ),
    Setting('window.seconds', 2.0, 'after so long fewer frames will do [s]', 0.0, 3600.0),
    Setting(
        'refit',
        'tracking',
        'after a fit: move the values with every frame (tracking), stop (once), or fit every new '
        'window from the last values (continuous); a body in motion: every new swing, unless once',
        choices=REFITS,
    ),
    Setting(
        'tracking.memory',
        0.5,
        'age at which a frame weighs 1/e of the newest [s]; longer is quieter, shorter follows '
        'sooner',
        0.01,
        3600.0,
    ),
    Setting(
        'tracking.change',
        0.05,
        'relative change of a modulus or density that is told on ~/change; other parameters in '
        'proportion to their usual steps',
        0.001,
        10.0,
    ),
    Setting(
        'tracking.picture_rate',
        2.0,
        'rendered, residual and mesh a second at most while tracking, when somebody subscribes '
        '[Hz]; 0: none',
        0.0,
        100.0,
    ),
    Setting(
        'publish_tf',
        True,
        "send to TF where the scene's world and the body are, as children of the depth camera, "
        'unless other nodes tell of them',
        is_read_only=True,
    ),
    Setting(
        'world_frame',
        'scene_world',
        "the scene's world in TF, unless its pose has a world_frame; empty: not sent",
    ),
    Setting('body_frame', 'body', "the mesh file's own axes in TF; empty: not sent"),
    Setting('out', 'diffcal_result', 'folder that ~/save writes to'),
    PERIOD,
)


def session_settings(values: Values) -> SessionSettings:
    """Turn parameters into settings.

    Raises:
        InputError: when they do not go together.
    """
    require_device(values['device'])
    names = tuple(name.strip() for name in values['fit'].split(',') if name.strip())
    return SessionSettings(
        fit=CalibrationSettings(
            fit=names or None,
            loss=values['loss'],
            optimizer=values['optimizer'],
            max_iterations=values['max_iterations'] or None,
            device=values['device'],
            with_mesh_error=values['mesh_error'],
        ),
        pose_source=values['pose_source'],
        observation=values['observation'],
        window_frames=values['window.frames'],
        window_seconds=values['window.seconds'],
        refit=values['refit'],
        depth_quantization=values['depth_quantization'],
        tracking=TrackingSettings(
            tracker=TrackerSettings(
                memory=values['tracking.memory'], change=values['tracking.change']
            ),
            picture_rate=values['tracking.picture_rate'],
        ),
    )
