# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Start the package's executables as `ros2 run` does, and end them."""

from collections.abc import Mapping
import ctypes
import os
from pathlib import Path
import secrets
import signal
import subprocess
import sys
from types import TracebackType

from ament_index_python.packages import (
    get_package_prefix,
    get_package_share_directory,
    PackageNotFoundError,
)

PACKAGE = 'diffcal_ros'
_PATIENCE = 6.0  # A node that compiles needs two seconds to notice that it is to end [s].
_SET_PARENT_DEATH_SIGNAL = 1  # prctl(2), Linux.


class DemoError(Exception):
    """The demonstration cannot go on; the message says why."""


def join_quiet_domain() -> None:
    """Set this process and its children apart from other ROS systems, on this machine only."""
    # Beyond 101 Linux may have given the ports away.
    os.environ['ROS_DOMAIN_ID'] = str(1 + secrets.randbelow(101))
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    try:
        share = Path(get_package_share_directory(PACKAGE))
    except PackageNotFoundError as error:
        raise DemoError(
            f'{PACKAGE} is not built or install/setup.bash is not sourced: run `make demo`'
        ) from error
    profile = share / 'config' / 'fastdds_large_images.xml'
    os.environ['FASTRTPS_DEFAULT_PROFILES_FILE'] = str(profile)


class NodeProcess:
    """One executable of the package as a child process."""

    def __init__(self, name: str, parameters: Mapping[str, object], log: Path) -> None:
        """Start it.

        Args:
            name: of the executable.
            parameters: of the node, as on the command line.
            log: where its output goes.
        """
        self.name = name
        self._log = log
        log.parent.mkdir(parents=True, exist_ok=True)
        program = Path(get_package_prefix(PACKAGE)) / 'lib' / PACKAGE / name
        arguments = [str(program), '--ros-args']
        for key, value in parameters.items():
            arguments += ['-p', f'{key}:={value}']
        with log.open('wb') as output:
            self._child = subprocess.Popen(
                arguments,
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                # Ctrl-C reaches us, and we end the nodes.
                start_new_session=True,
                preexec_fn=_end_with_parent if sys.platform == 'linux' else None,
            )

    @property
    def process_id(self) -> int:
        """Of the operating system."""
        return self._child.pid

    def check(self) -> None:
        """Raise DemoError when it has ended, with the last it said."""
        code = self._child.poll()
        if code is not None:
            last = '\n'.join(self._log.read_text(errors='replace').splitlines()[-5:])
            raise DemoError(f'{self.name} ended with code {code}, see {self._log}:\n{last}')

    def interrupt(self) -> None:
        """Tell it to end, as Ctrl-C does."""
        if self._child.poll() is None:
            self._child.send_signal(signal.SIGINT)

    def wait(self) -> None:
        """Wait until it has ended; one that does not listen is killed."""
        try:
            self._child.wait(_PATIENCE)
        except subprocess.TimeoutExpired:
            self._child.kill()
            self._child.wait()


class NodeGroup:
    """Nodes that end together, whatever happens; use it in a `with` block."""

    def __init__(self, log: Path) -> None:
        """Start empty; `log` is the folder of their output."""
        self._log = log
        self._nodes: list[NodeProcess] = []

    def __enter__(self) -> 'NodeGroup':
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        # All at once first, so that their endings do not add up.
        for node in self._nodes:
            node.interrupt()
        for node in self._nodes:
            node.wait()

    def start(self, name: str, **parameters: object) -> None:
        """Start an executable with parameters of its node."""
        self._nodes.append(NodeProcess(name, parameters, self._log / f'{name}.log'))

    def process_id(self, name: str) -> int:
        """Return the process id of an executable that was started."""
        return next(node.process_id for node in self._nodes if node.name == name)

    def check(self) -> None:
        """Raise DemoError when one has ended."""
        for node in self._nodes:
            node.check()


def _end_with_parent() -> None:
    """Let the kernel end the child if we are killed without a chance to do it."""
    ctypes.CDLL(None).prctl(_SET_PARENT_DEATH_SIGNAL, signal.SIGINT)
