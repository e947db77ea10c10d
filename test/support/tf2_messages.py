# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""tf2_msgs/TFMessage where it is not installed, as beside PyPI's wheels: built from its one line.

The generators come with the wheels, so what goes over DDS is the very type; a compiler is needed.
"""

from collections.abc import Sequence
import contextlib
import fcntl
from importlib.metadata import entry_points
from importlib.util import find_spec
import os
from pathlib import Path
import shutil
import subprocess
import sys
import sysconfig
from typing import Any

import numpy as np

_PACKAGE, _MESSAGE = 'tf2_msgs', 'geometry_msgs/TransformStamped[] transforms\n'
_GROUP = 'rosidl_cli.command.generate.{}_extensions'
_COMPILER = ('-O1', '-shared', '-fPIC', '-Wl,--no-as-needed')


def provide_tf2_messages(cache: Path) -> str:
    """Make `tf2_msgs.msg` importable; return why it is not, or an empty text.

    Args:
        cache: folder that lasts from one run to the next.
    """
    if find_spec(_PACKAGE) is not None:
        return ''
    for tool in ('gcc', 'g++'):
        if shutil.which(tool) is None:
            return f'tf2_msgs is not installed, nor is {tool}, which could build it'
    if find_spec('rosidl_generator_py') is None:
        return 'tf2_msgs is not installed, nor are the generators of messages'
    root = cache / f'{_PACKAGE}-{sysconfig.get_config_var("EXT_SUFFIX")}'
    cache.mkdir(parents=True, exist_ok=True)
    with (cache / f'{_PACKAGE}.lock').open('w') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (root / 'done').exists():
            shutil.rmtree(root, ignore_errors=True)
            _generate(root)
            _compile(root)
            (root / 'done').touch()
    sys.path.append(str(root))
    return ''


def withdraw_tf2_messages(cache: Path) -> None:
    """Undo it, for tests of what is told without the package."""
    sys.path[:] = [place for place in sys.path if not place.startswith(str(cache))]
    for name in [name for name in sys.modules if name.partition('.')[0] == _PACKAGE]:
        del sys.modules[name]


def _generate(root: Path) -> None:
    from rosidl_adapter.msg import convert_msg_to_idl

    # The generators look for each other there; colcon has set it to what it built.
    others = os.environ.get('AMENT_PREFIX_PATH')
    os.environ['AMENT_PREFIX_PATH'] = os.pathsep.join(filter(None, (sys.prefix, others)))
    source = root / 'source'
    (source / 'msg').mkdir(parents=True)
    (source / 'msg' / 'TFMessage.msg').write_text(_MESSAGE)
    interface = f'{source}:msg/TFMessage.idl'
    places = {'': root / _PACKAGE, 'introspection_c': root / 'introspection' / _PACKAGE}
    # The generators tell of each file.
    with (
        Path(os.devnull).open('w') as quiet,
        contextlib.redirect_stdout(quiet),
        contextlib.redirect_stderr(quiet),
    ):
        convert_msg_to_idl(source, _PACKAGE, Path('msg/TFMessage.msg'), source / 'msg')
        for group, name in (
            ('type', 'c'),
            ('typesupport', 'c'),
            ('typesupport', 'fastrtps_c'),
            ('typesupport', 'introspection_c'),
            ('type', 'py'),
        ):
            place = places.get(name, places[''])
            place.mkdir(parents=True, exist_ok=True)
            generator = _generator(group, name)
            generator.generate(_PACKAGE, [interface], [f'{sys.prefix}/share'], place)
    (places[''] / '__init__.py').touch()


def _generator(group: str, name: str) -> Any:
    entry = next(one for one in entry_points(group=_GROUP.format(group)) if one.name == name)
    if name == 'py':
        return entry.load()(name, typesupport_implementations=['rosidl_typesupport_c'])
    return entry.load()(name)


def _compile(root: Path) -> None:
    made, msg = root / _PACKAGE, root / _PACKAGE / 'msg'
    parts = ('description', 'functions', 'type_support')
    _link(root, 'rosidl_generator_c', [msg / f'detail/tf_message__{part}.c' for part in parts])
    beside = ['rosidl_generator_c']
    other = root / 'introspection' / _PACKAGE / 'msg' / 'detail' / 'tf_message__type_support.c'
    _link(root, 'rosidl_typesupport_introspection_c', [other], beside)
    packed = msg / 'detail' / 'tf_message__type_support_c.cpp'
    _link(root, 'rosidl_typesupport_fastrtps_c', [packed], beside, ['fastcdr'])
    beside += ['rosidl_typesupport_introspection_c', 'rosidl_typesupport_fastrtps_c']
    _link(root, 'rosidl_typesupport_c', [msg / 'tf_message__type_support.cpp'], beside)
    beside.append('rosidl_typesupport_c')
    sources = [msg / '_tf_message_s.c', made / f'_{_PACKAGE}_s.ep.rosidl_typesupport_c.c']
    extension = made / f'{_PACKAGE}_s__rosidl_typesupport_c.so'
    _run(root, sources, extension, beside, ['geometry_msgs__rosidl_generator_py'])


def _link(
    root: Path,
    part: str,
    sources: Sequence[Path],
    beside: Sequence[str] = (),
    libraries: Sequence[str] = (),
) -> None:
    name = f'lib{_PACKAGE}__{part}.so'
    has_own = 'typesupport' in part
    needed = [f'geometry_msgs__{part}', *([part] if has_own else []), *libraries]
    _run(root, sources, root / 'lib' / name, beside, needed, f'-Wl,-soname,{name}')


def _run(
    root: Path,
    sources: Sequence[Path],
    target: Path,
    beside: Sequence[str],
    libraries: Sequence[str],
    *options: str,
) -> None:
    target.parent.mkdir(exist_ok=True)
    wheels, own = Path(sys.prefix) / 'lib', root / 'lib'
    shared = Path(sys.prefix) / 'include'
    headers = [root, root / 'introspection', shared, *shared.glob('*/')]
    headers += [Path(sysconfig.get_path('include')), Path(np.get_include())]
    command = ['g++' if sources[0].suffix == '.cpp' else 'gcc', *_COMPILER, *options]
    command += [f'-I{folder}' for folder in headers]
    command += [*map(str, sources), '-o', str(target), f'-L{own}', f'-L{wheels}']
    command += [f'-Wl,-rpath,{own}:{wheels}']
    command += [f'-l{_PACKAGE}__{part}' for part in beside]
    command += [f'-l{name}' for name in (*libraries, 'rosidl_runtime_c', 'rcutils')]
    subprocess.run(command, check=True, capture_output=True)
