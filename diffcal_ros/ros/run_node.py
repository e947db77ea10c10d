# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Start a node, spin it, and end it without a stack trace."""

from collections.abc import Sequence
from importlib import import_module
import os
import signal
import sys
from typing import Any

from diffcal_ros.blas_threads import keep_blas_to_one_thread

EXIT_DONE = 0
EXIT_BAD_INPUT = 2
# What neither ROS nor apt brings in the versions that are needed (requirements.txt).
PIP_PACKAGES = (
    'joblib',
    'lz4',
    'mcap',
    'meshio',
    'opencv-contrib-python-headless',
    'qdldl',
    'rosbags',
    'threadpoolctl',
    'trimesh',
    'warp-lang',
    'zstandard',
)
# How long after the start a node of the same name is looked for, and how often [s].
_WATCH, _WATCH_PERIOD = 2.0, 0.1


def run_node(module: str, name: str, arguments: Sequence[str] | None = None) -> int:
    """Run a node until it is told to stop; return the exit code.

    Args:
        module: where its class is; imported here, so that an interruption meanwhile is handled.
        name: of the class.
        arguments: of the command line; default: this process's.
    """
    keep_blas_to_one_thread()
    try:
        import rclpy

        make = getattr(import_module(module), name)
    except KeyboardInterrupt:
        return EXIT_DONE
    except ModuleNotFoundError as error:
        print(missing_package(error.name or str(error)), file=sys.stderr)
        return EXIT_BAD_INPUT
    # A report's pictures go to files: what is stated for windows need not be there.
    os.environ.pop('MPLBACKEND', None)
    # rclpy ends the context on SIGINT; a KeyboardInterrupt besides could strike anywhere.
    signal.signal(signal.SIGINT, lambda *_: None)
    try:
        rclpy.init(args=arguments)
    except RuntimeError as error:
        print(_not_started(error), file=sys.stderr)
        return EXIT_BAD_INPUT
    try:
        return _spin(make)
    finally:
        rclpy.try_shutdown()


def _not_started(error: RuntimeError) -> str:
    """Say what may be the cause where ROS itself gives up; where in its source is left out."""
    reason = str(error).partition(', at /')[0]
    return (
        f'ROS cannot be started ({reason}): check what follows --ros-args, and ROS_DOMAIN_ID '
        '(0 to 101), ROS_LOG_DIR and RMW_IMPLEMENTATION in the environment'
    )


def missing_package(module: str) -> str:
    """Say which package is missing, and how to install it.

    Args:
        module: that was not found.
    """
    package = module.partition('.')[0]
    if package == 'rclpy' or package.endswith(('_msgs', '_interfaces')):
        cure = "source ROS 2's setup.bash, or install the wheels: make build"
    else:
        cure = f'install what pip brings: {sys.executable} -m pip install {" ".join(PIP_PACKAGES)}'
    return f'diffcal_ros needs the Python package {package!r}, which is not installed: {cure}'


def _spin(make: Any) -> int:
    from diffcal_ros.errors import InputError
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
    from rclpy.impl.implementation_singleton import rclpy_implementation
    from rclpy.logging import get_logger

    try:
        node = make()
    except InputError as error:
        get_logger('diffcal_ros').fatal(str(error))
        return EXIT_BAD_INPUT
    except rclpy_implementation.RCLError as error:
        get_logger('diffcal_ros').fatal(_not_started(error))
        return EXIT_BAD_INPUT
    except ExternalShutdownException:
        return EXIT_DONE
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    watch = _NameWatch(node)
    try:
        while not watch.is_taken:
            executor.spin_once()
    except ExternalShutdownException:
        pass
    except Exception:  # An end that comes between two looks at the context shows as any error.
        if node.context.ok():
            raise
    is_idle = node.close()
    executor.shutdown()
    node.destroy_node()
    code = EXIT_BAD_INPUT if watch.is_taken else EXIT_DONE
    if not is_idle:
        # A thread is inside a compiler: the interpreter must not be torn down under it.
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    return code


class _NameWatch:
    """Looks for another node of the same name for a while."""

    def __init__(self, node: Any) -> None:
        from rclpy.clock import Clock
        from rclpy.clock_type import ClockType

        self.is_taken = False
        self._node = node
        self._left = int(_WATCH / _WATCH_PERIOD)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._timer = node.create_timer(_WATCH_PERIOD, self._look, clock=steady)

    def _look(self) -> None:
        own = (self._node.get_name(), self._node.get_namespace())
        names = self._node.get_node_names_and_namespaces()
        self.is_taken = sum(tuple(name) == own for name in names) > 1
        if self.is_taken:
            self._node.get_logger().fatal(
                f'another node is called {self._node.get_fully_qualified_name()} (it runs, or '
                'was killed within the last 20 seconds): stop it, or start this one under '
                'another name with --ros-args -r __node:=NAME'
            )
        self._left -= 1
        if self._left <= 0:
            self._timer.cancel()
