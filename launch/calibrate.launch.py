# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Start depth source, marker pose, calibration and RViz.

    ros2 launch diffcal_ros calibrate.launch.py scene:=SCENE.yaml bag:=BAG
    ros2 launch diffcal_ros calibrate.launch.py scene:=SCENE.yaml camera:=/camera/camera

The first line replays a recording, the second one listens to a camera.
"""

from pathlib import Path

from ament_index_python.packages import get_package_share_directory
from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, SetEnvironmentVariable
from launch.conditions import IfCondition
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node
from launch_ros.parameter_descriptions import ParameterValue

PACKAGE = 'diffcal_ros'
SHARE = Path(get_package_share_directory(PACKAGE))
ARGUMENTS = (
    ('scene', None, 'scene file (whole path)'),
    ('bag', '', 'recording to replay (whole path); empty: the live camera'),
    ('camera', '/camera/camera', 'namespace of the live camera, as of realsense2_camera'),
    ('out', 'diffcal_result', 'folder that the service calibration/save writes to'),
    ('params_file', str(SHARE / 'config' / 'calibrate.yaml'), 'parameters of the three nodes'),
    ('rviz', 'true', 'start RViz'),
)
CAMERA_TOPICS = (
    'depth/image_rect_raw',
    'depth/camera_info',
    'color/image_raw',
    'color/camera_info',
)


def generate_launch_description() -> LaunchDescription:
    """Describe what is started."""
    camera = LaunchConfiguration('camera')
    scene, out = _text('scene'), _text('out')
    return LaunchDescription(
        [
            *(
                DeclareLaunchArgument(name, default_value=default, description=description)
                for name, default, description in ARGUMENTS
            ),
            # Depth images are larger than Fast DDS's usual shared memory.
            SetEnvironmentVariable(
                'FASTRTPS_DEFAULT_PROFILES_FILE',
                str(SHARE / 'config' / 'fastdds_large_images.xml'),
            ),
            # First, because it compiles kernels, the first time on a machine.
            _node('calibration', {'scene': scene, 'out': out}),
            _node('marker_pose', {'scene': scene}),
            _node(
                'depth_source',
                {'bag': _text('bag'), 'subscribers': 2, 'wait_for_subscriber': 60.0},
                [(f'in/{topic}', [camera, f'/{topic}']) for topic in CAMERA_TOPICS],
            ),
            Node(
                package='rviz2',
                executable='rviz2',
                arguments=['-d', str(SHARE / 'rviz' / 'calibrate.rviz')],
                condition=IfCondition(LaunchConfiguration('rviz')),
            ),
        ]
    )


def _node(name: str, parameters: dict, remappings: list | None = None) -> Node:
    return Node(
        package=PACKAGE,
        executable=name,
        name=name,
        parameters=[LaunchConfiguration('params_file'), parameters],
        remappings=remappings or [],
        output='screen',
    )


def _text(name: str) -> ParameterValue:
    """Return an argument as text, even where it looks like a number."""
    return ParameterValue(LaunchConfiguration(name), value_type=str)
