# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Errors that a user can mend: one sentence that says what was given, needed, and to be done."""

from diffcal_ros.plain_text import plain

# What a file has put into a message does not fill the screen.
_LONGEST = 1500


class InputError(ValueError):
    """Something the user gave is wrong; the command line prints the message and exits with 2."""


class SceneError(InputError):
    """A scene is wrong; the message names the key, the value given and what is allowed."""


class NotSimulatedError(RuntimeError):
    """A model cannot be simulated somewhere, or its body not be seen; the message says why."""


class RecordingError(InputError):
    """A recording cannot be used; the message names the file and what is needed."""

    def __init__(self, message: str) -> None:
        """Take a message that may hold text of the recording."""
        super().__init__(plain(message, _LONGEST))


class PoseError(InputError):
    """No camera pose can be had; the message says why."""

    def __init__(self, message: str) -> None:
        """Take a message that may hold text of the recording."""
        super().__init__(plain(message, _LONGEST))
