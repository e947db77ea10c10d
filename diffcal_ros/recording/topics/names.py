# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Topics, message types and frames of the recordings that this package writes."""

DEPTH_IMAGE = '/depth/image_rect_raw'
DEPTH_CAMERA_INFO = '/depth/camera_info'
COLOR_IMAGE = '/color/image_raw'
COLOR_CAMERA_INFO = '/color/camera_info'
TF = '/tf'
TF_STATIC = '/tf_static'
DEPTH_FROM_COLOR = '/depth_from_color'

DEPTH_FRAME = 'camera_depth_optical_frame'
COLOR_FRAME = 'camera_color_optical_frame'

IMAGE_TYPE = 'sensor_msgs/msg/Image'
COMPRESSED_IMAGE_TYPE = 'sensor_msgs/msg/CompressedImage'
CAMERA_INFO_TYPE = 'sensor_msgs/msg/CameraInfo'
TRANSFORM_TYPE = 'geometry_msgs/msg/TransformStamped'
TF_TYPE = 'tf2_msgs/msg/TFMessage'
POSE_TYPE = 'geometry_msgs/msg/PoseStamped'
POSE_COVARIANCE_TYPE = 'geometry_msgs/msg/PoseWithCovarianceStamped'


# What image_transport appends to the name of a topic that it packs.
COMPRESSED = '/compressed'
COMPRESSED_DEPTH = '/compressedDepth'


def plain_topic(image_topic: str) -> str:
    """Return the topic whose images a topic of image_transport packs, or the topic itself."""
    return image_topic.removesuffix(COMPRESSED).removesuffix(COMPRESSED_DEPTH)


def camera_info_of(image_topic: str) -> str:
    """Return the camera_info topic in the same namespace as an image topic."""
    return f'{plain_topic(image_topic).rpartition("/")[0]}/camera_info'
