# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Standard output and error that nobody reads, or that are full, must not cost a result."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
import os
import sys
from typing import Any

_STREAMS = ('stdout', 'stderr')


class LastingStream:
    """A text stream that goes on after it has failed, and remembers why.

    Characters that its encoding lacks are written as escapes.
    """

    def __init__(self, stream: Any) -> None:
        self._stream = stream
        self.fault: OSError | None = None

    def write(self, text: str) -> int:
        """Write, or do nothing once that has failed."""
        if self.fault is not None:
            return len(text)
        try:
            self._stream.write(self._printable(text))
        except OSError as error:
            self._give_up(error)
        return len(text)

    def flush(self) -> None:
        """Hand on what was written."""
        if self.fault is not None:
            return
        try:
            self._stream.flush()
        except OSError as error:
            self._give_up(error)

    def _printable(self, text: str) -> str:
        encoding = getattr(self._stream, 'encoding', None) or 'utf-8'
        return text.encode(encoding, errors='backslashreplace').decode(encoding)

    def _give_up(self, error: OSError) -> None:
        self.fault = error
        # What its buffer still holds would fail again when Python ends, and change the exit code.
        with suppress(OSError, ValueError, AttributeError):
            nowhere = os.open(os.devnull, os.O_WRONLY)
            os.dup2(nowhere, self._stream.fileno())
            os.close(nowhere)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def lasting_streams() -> Iterator[LastingStream]:
    """Put lasting streams in place of standard output and error; offer the one for output."""
    _open_what_is_closed()
    kept = {name: getattr(sys, name) for name in _STREAMS}
    lasting = {name: LastingStream(stream) for name, stream in kept.items()}
    for name, stream in lasting.items():
        setattr(sys, name, stream)
    try:
        yield lasting['stdout']
    finally:
        for name, stream in kept.items():
            lasting[name].flush()
            setattr(sys, name, stream)


def _open_what_is_closed() -> None:
    """Where a shell closed a stream (`>&-`), the next file would take its number."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    for name in _STREAMS:
        if getattr(sys, name) is None:
            setattr(sys, name, open(os.devnull, 'w', encoding='utf-8'))  # noqa: SIM115
