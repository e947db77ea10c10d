# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Read one YAML mapping and remember on which line each key stands."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diffcal_ros.errors import InputError, SceneError
from diffcal_ros.scene.reading.yaml_limits import MOST_BYTES, require_limits
from diffcal_ros.user_path import require_plain_file
import yaml

# What PyYAML trips over where a tag such as `!!int` stands before something else.
_MISFITS = (ValueError, LookupError, TypeError, AttributeError, OverflowError)


@dataclass(frozen=True)
class YamlDocument:
    """The content of a YAML file.

    Attributes:
        content: top-level mapping.
        lines: line number, from 1, of each dotted key; list items are `key[0]`, `key[1]` ...
    """

    content: dict[str, Any]
    lines: dict[str, int]


def read_yaml(path: Path, kind: str = 'scene') -> YamlDocument:
    """Read a file that holds one mapping.

    Args:
        path: the file.
        kind: what it is, for messages.

    Raises:
        SceneError: when there is no such file, it is not YAML, it is larger than a scene can
            be, or a key stands in it twice.
    """
    text = read_text(path, kind)
    try:
        # The pure Python loader: the C one crashes the interpreter on very deep nesting.
        loader = yaml.SafeLoader(text)
        root = loader.get_single_node()
        if root is not None:
            require_limits(path, root)
        content = loader.construct_document(root) if root is not None else None
    except SceneError:
        raise
    except yaml.YAMLError as error:
        raise SceneError(_syntax_sentence(path, error)) from error
    except RecursionError as error:
        raise SceneError(f'{path} is nested too deeply: give a {kind} file') from error
    except _MISFITS as error:
        raise SceneError(
            f'{path} holds a value that YAML cannot read ({error}): put texts in quotes'
        ) from error
    if root is None or not isinstance(content, dict):
        given = 'empty' if content is None else f'a {type(content).__name__}, not a mapping'
        raise SceneError(f'{path} is {given}: a {kind} file starts with `format: 1`')
    lines: dict[str, int] = {}
    repeated = list(_walk(root, '', lines, set()))
    if repeated:
        raise SceneError(f'{path}: ' + '; '.join(repeated) + '; keep one of each')
    return YamlDocument(content, lines)


def read_text(path: Path, kind: str = 'scene') -> str:
    """Read a text file; see `read_yaml`.

    Raises:
        SceneError: when it is not there, is too large, or is no text in UTF-8.
    """
    made = ', or make one with `diffcal init` or `diffcal import`' if kind == 'scene' else ''
    try:
        require_plain_file(path, MOST_BYTES)
        return path.read_text(encoding='utf-8')
    except InputError as error:
        raise SceneError(str(error)) from error
    except FileNotFoundError as error:
        raise SceneError(f'there is no {kind} file {path}: check the path{made}') from error
    except OSError as error:
        raise SceneError(f'{path} cannot be read ({error.strerror}): check its rights') from error
    except UnicodeDecodeError as error:
        form = 'CSV' if path.suffix.lower() == '.csv' else 'YAML'
        raise SceneError(f'{path} is no text file: a {kind} is {form} in UTF-8') from error


def _syntax_sentence(path: Path, error: yaml.YAMLError) -> str:
    mark = getattr(error, 'problem_mark', None)
    where = f'{path}, line {mark.line + 1}, column {mark.column + 1}' if mark else str(path)
    what = getattr(error, 'problem', None) or str(error).splitlines()[0]
    return f'{where}: not readable as YAML ({what}): check indentation, colons and brackets'


def _walk(node: yaml.Node, key: str, lines: dict[str, int], seen: set[int]) -> Iterator[str]:
    """Fill `lines`; yield a phrase for each key that stands twice in one mapping."""
    if id(node) in seen:
        return  # An alias; its anchor was walked.
    seen.add(id(node))
    if isinstance(node, yaml.MappingNode):
        yield from _walk_mapping(node, key, lines, seen)
    elif isinstance(node, yaml.SequenceNode):
        for index, item in enumerate(node.value):
            item_key = f'{key}[{index}]'
            lines[item_key] = item.start_mark.line + 1
            yield from _walk(item, item_key, lines, seen)


def _walk_mapping(
    node: yaml.MappingNode, key: str, lines: dict[str, int], seen: set[int]
) -> Iterator[str]:
    own: dict[str, int] = {}
    for key_node, value_node in node.value:
        name = f'{key}.{key_node.value}' if key else str(key_node.value)
        line = key_node.start_mark.line + 1
        if name in own and key_node.value != '<<':
            yield f'`{name}` stands on line {own[name]} and again on line {line}'
        own[name] = lines[name] = line
        yield from _walk(value_node, name, lines, seen)
