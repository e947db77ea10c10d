# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Start depth source, marker pose, calibration and RViz.

    ros2 launch diffcal_ros calibrate.launch.py scene:=SCENE.yaml bag:=BAG
    ros2 launch diffcal_ros calibrate.launch.py scene:=SCENE.yaml camera:=orbbec rviz:=false

The first line replays a recording, the second one listens to a camera.
"""

from pathlib import Path

from ament_index_python.packages import (
    get_package_prefix,
    get_package_share_directory,
    PackageNotFoundError,
)
from launch import LaunchContext, LaunchDescription
from launch.actions import (
    DeclareLaunchArgument,
    GroupAction,
    OpaqueFunction,
    SetEnvironmentVariable,
)
from launch.conditions import IfCondition
from launch.logging import get_logger
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node, PushRosNamespace
from launch_ros.parameter_descriptions import ParameterValue

PACKAGE = 'diffcal_ros'
SHARE = Path(get_package_share_directory(PACKAGE))
INPUTS = ('depth/image_rect_raw', 'depth/camera_info', 'color/image_raw', 'color/camera_info')
# What drivers call the four inputs when they are started with their own defaults.
CAMERAS = {
    'realsense': tuple(f'/camera/camera/{topic}' for topic in INPUTS),
    'orbbec': (
        '/camera/depth/image_raw',
        '/camera/depth/camera_info',
        '/camera/color/image_raw',
        '/camera/color/camera_info',
    ),
    # Its raw depth is distorted: image_proc has to rectify it, and keeps the camera_info.
    'azure_kinect': (
        '/depth/image_rect',
        '/depth/camera_info',
        '/rgb/image_raw',
        '/rgb/camera_info',
    ),
    'zed': (
        '/zed/zed_node/depth/depth_registered',
        '/zed/zed_node/depth/camera_info',
        '/zed/zed_node/rgb/color/rect/image',
        '/zed/zed_node/rgb/color/rect/camera_info',
    ),
}
# One a topic of INPUTS: goes before what the camera says.
TOPIC_ARGUMENTS = ('depth_topic', 'depth_info_topic', 'color_topic', 'color_info_topic')
FLAGS = ('use_sim_time', 'loop', 'rviz')
ARGUMENTS = (
    ('scene', None, 'scene file (whole path)'),
    ('bag', '', 'recording to replay (whole path); empty: the live camera'),
    (
        'camera',
        'realsense',
        f"whose driver's topics are read: {', '.join(CAMERAS)}; or the namespace, such as "
        "/arm/camera, of topics that are called as realsense2_camera's",
    ),
    *(
        (name, '', f"live topic for in/{topic}; empty: the camera's")
        for name, topic in zip(TOPIC_ARGUMENTS, INPUTS, strict=True)
    ),
    ('namespace', '', 'namespace of the nodes, their topics and services'),
    (
        'use_sim_time',
        'false',
        'the nodes follow /clock, where the depth source sends the time of the bag',
    ),
    ('rate', '', "times the recording's own pace; empty: as params_file says"),
    ('loop', '', 'start the recording again at its end; empty: as params_file says'),
    ('out', '', 'folder that calibration/save writes to; empty: as params_file says'),
    ('params_file', str(SHARE / 'config' / 'calibrate.yaml'), 'parameters of the three nodes'),
    ('rviz', 'true', 'start RViz where it is installed; false on a robot'),
)


def generate_launch_description() -> LaunchDescription:
    """Describe what is started."""
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, default, description in ARGUMENTS
            ),
            OpaqueFunction(function=check_arguments),
            # Depth images are larger than Fast DDS's usual shared memory.
            SetEnvironmentVariable(
                'FASTRTPS_DEFAULT_PROFILES_FILE',
                str(SHARE / 'config' / 'fastdds_large_images.xml'),
            ),
            GroupAction(
                [
                    PushRosNamespace(LaunchConfiguration('namespace')),
                    OpaqueFunction(function=_nodes),
                    OpaqueFunction(
                        function=_rviz, condition=IfCondition(LaunchConfiguration('rviz'))
                    ),
                ]
            ),
        ]
    )


def check_arguments(context: LaunchContext) -> None:
    """Refuse what could not be used before anything is started, which would be left running.

    Raises:
        ValueError: for a value of another kind than is needed.
    """

    def given(name: str) -> str:
        return str(LaunchConfiguration(name).perform(context))

    for name in FLAGS:
        if given(name).lower() not in ('true', 'false', ''):
            raise ValueError(f'{name} is {given(name)!r}: use true or false')
    if not given('rviz') or not given('use_sim_time'):
        raise ValueError('rviz and use_sim_time must not be empty: use true or false')
    if given('rate'):
        try:
            float(given('rate'))
        except ValueError:
            raise ValueError(f'rate is {given("rate")!r}: use a number, such as 0.5') from None
    if not Path(given('params_file')).is_file():
        raise ValueError(f'there is no file {given("params_file")!r}: check params_file')
    camera_topics(context)


def camera_topics(context: LaunchContext) -> tuple[str, ...]:
    """Return the live topic of each of INPUTS.

    Raises:
        ValueError: for a camera that is neither known nor a namespace.
    """
    camera = LaunchConfiguration('camera').perform(context)
    if camera.startswith('/'):
        usual = tuple(f'{camera.rstrip("/")}/{topic}' for topic in INPUTS)
    elif camera in CAMERAS:
        usual = CAMERAS[camera]
    else:
        raise ValueError(
            f'camera is {camera!r}: use {", ".join(CAMERAS)}, or a namespace that begins with /'
        )
    given = (LaunchConfiguration(name).perform(context) for name in TOPIC_ARGUMENTS)
    return tuple(mine or topic for mine, topic in zip(given, usual, strict=True))


def _nodes(context: LaunchContext) -> list[Node]:
    sim_time = _given(context, use_sim_time=bool)
    scene = {**sim_time, **_given(context, scene=str)}
    replay = {**sim_time, **_given(context, bag=str, rate=float, loop=bool)}
    if 'bag' in replay:
        # Only a recording has a time of its own to send.
        replay['publish_clock'] = sim_time['use_sim_time']
    inputs = zip(INPUTS, camera_topics(context), strict=True)
    return [
        # First, because it compiles kernels, the first time on a machine.
        _node('calibration', {**scene, **_given(context, out=str)}),
        _node('marker_pose', scene),
        _node(
            'depth_source',
            {**replay, 'subscribers': 2, 'wait_for_subscriber': 300.0},
            [(f'in/{name}', topic) for name, topic in inputs],
        ),
    ]


def _rviz(context: LaunchContext) -> list[Node]:
    try:
        get_package_prefix('rviz2')
    except PackageNotFoundError:
        get_logger('launch').warning(
            'rviz2 is not installed: the nodes run without it (rviz:=false leaves it out)'
        )
        return []
    return [
        Node(
            package='rviz2',
            executable='rviz2',
            arguments=['-d', str(SHARE / 'rviz' / 'calibrate.rviz')],
            parameters=[_given(context, use_sim_time=bool)],
        )
    ]


def _node(name: str, parameters: dict, remappings: list | None = None) -> Node:
    return Node(
        package=PACKAGE,
        executable=name,
        name=name,
        parameters=[LaunchConfiguration('params_file'), parameters],
        remappings=remappings or [],
        output='screen',
        # On a busy machine a node may take longer than the usual five to put itself in order [s].
        sigterm_timeout='20',
        sigkill_timeout='20',
    )


def _given(context: LaunchContext, **kinds: type) -> dict[str, ParameterValue]:
    """Return those arguments that are not empty, a text even where it looks like a number."""
    return {
        name: ParameterValue(LaunchConfiguration(name), value_type=kind)
        for name, kind in kinds.items()
        if LaunchConfiguration(name).perform(context)
    }
