# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Sentences of the library as a node says them: its parameters in place of options."""

import re

from diffcal_ros.camera import PinholeCamera
from diffcal_ros.errors import InputError

# Options of the command line whose parameter is called otherwise.
_RENAMED = {'pose': 'pose_source'}
_KNOWN = (
    'allow-truncated',
    'depth-topic',
    'fit',
    'loss',
    'max-iterations',
    'optimizer',
    'pose',
)
# Cures of the command line that a node has as services.
_SERVICES = (
    (re.compile(r'run `diffcal diagnose [^`]*` first'), 'call ~/diagnose first'),
    (re.compile(r'with `diffcal revert`'), 'with ~/revert_effect'),
    (re.compile(r'with --effect'), 'with `diffcal accept --effect`'),
)
_OPTION = re.compile(rf'--({"|".join(_KNOWN)})(?![a-z-])')


def for_nodes(sentence: str) -> str:
    """Return a sentence with parameters of the nodes in place of options of `diffcal`."""

    def parameter(found: re.Match[str]) -> str:
        name = found.group(1)
        return f'the parameter {_RENAMED.get(name, name.replace("-", "_"))}'

    for option, service in _SERVICES:
        sentence = option.sub(service, sentence)
    return _OPTION.sub(parameter, sentence)


def told_of(topic: str, reason: str) -> str:
    """Say what is wrong with a topic, which is named once."""
    return reason if reason.startswith(topic) else f'{topic}: {reason}'


def camera_change_words(before: PinholeCamera, after: PinholeCamera) -> str:
    """Name what differs between two cameras."""
    return ', '.join(
        f'{name} {getattr(before, name):.6g} -> {getattr(after, name):.6g}'
        for name in ('width', 'height', 'fx', 'fy', 'cx', 'cy')
        if getattr(before, name) != getattr(after, name)
    )


def error_words(error: Exception) -> str:
    """Say why a fit broke off."""
    if isinstance(error, InputError):
        return str(error)
    return f'the fit broke off ({type(error).__name__}: {error}): please report this'
