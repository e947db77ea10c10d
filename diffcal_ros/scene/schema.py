# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The JSON schema of a scene file, for editors, made of the shapes that the reader goes by.

Draft 7, which YAML editors know. It tells keys, kinds and ranges; what depends on several keys, or
on the mesh, only `diffcal check` tells.
"""

from functools import singledispatch
import json
from typing import Any

from diffcal_ros.scene.reading.shapes import (
    ANY_NAME,
    Choice,
    Constant,
    Flag,
    Keys,
    ListOf,
    Number,
    OneOf,
    Shape,
    SMALLEST,
    Text,
    Whole,
)
from diffcal_ros.scene.scene_shape import SCENE_SHAPE
import numpy as np

DRAFT = 'http://json-schema.org/draft-07/schema#'
# A number in quotes, or one that YAML takes for a text, as `1e5`.
_WRITTEN_NUMBER = r'^\s*[-+]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][-+]?[0-9]+)?\s*$'

_CLOSED, _OPEN = ('minimum', 'maximum'), ('exclusiveMinimum', 'exclusiveMaximum')


def scene_schema() -> dict[str, Any]:
    """Return the schema of a scene file, format 1."""
    return {'$schema': DRAFT, 'title': 'diffcal scene', **_schema(SCENE_SHAPE)}


def scene_schema_text() -> str:
    """Return the schema as the file `config/scene.schema.json` holds it."""
    return json.dumps(scene_schema(), indent=1, ensure_ascii=False) + '\n'


def _schema(shape: Shape) -> dict[str, Any]:
    about = {'description': shape.about} if shape.about else {}
    return {**about, **_content(shape)}


@singledispatch
def _content(shape: Shape) -> dict[str, Any]:
    raise TypeError(f'a shape is needed, not {shape!r}')


@_content.register
def _(shape: Number) -> dict[str, Any]:
    allowed = shape.allowed
    low, high = _OPEN if allowed.is_open else _CLOSED
    ends = {low: allowed.low, high: allowed.high}
    limits = {name: value for name, value in ends.items() if np.isfinite(value)}
    if allowed.is_open and allowed.low == 0.0:
        limits = {**limits, 'minimum': SMALLEST}
    return {'type': ['number', 'string'], 'pattern': _WRITTEN_NUMBER, **limits}


@_content.register
def _(shape: Whole) -> dict[str, Any]:
    ends = {'minimum': shape.low, 'maximum': shape.high}
    return {'type': 'integer', **{name: end for name, end in ends.items() if end is not None}}


@_content.register
def _(shape: Flag) -> dict[str, Any]:
    return {'type': 'boolean'}


@_content.register
def _(shape: Text) -> dict[str, Any]:
    return {'type': ['string', 'number'], 'minLength': 1}


@_content.register
def _(shape: Constant) -> dict[str, Any]:
    return {'const': shape.value}


@_content.register
def _(shape: Choice) -> dict[str, Any]:
    return {'enum': list(shape.names)}


@_content.register
def _(shape: ListOf) -> dict[str, Any]:
    most = {} if shape.most is None else {'maxItems': shape.most}
    return {'type': 'array', 'items': _schema(shape.item), 'minItems': shape.fewest, **most}


@_content.register
def _(shape: OneOf) -> dict[str, Any]:
    return {'anyOf': [_schema(one) for one in shape.shapes]}


@_content.register
def _(shape: Keys) -> dict[str, Any]:
    entries = {
        name: _schema(entry) if name in shape.required else _or_null(_schema(entry))
        for name, entry in shape.entries.items()
    }
    content: dict[str, Any] = {'type': 'object', 'additionalProperties': False}
    if entries:
        content['properties'] = entries
    if shape.required:
        content['required'] = list(shape.required)
    if shape.named is not None and entries:
        content['patternProperties'] = {f'^({shape.name_pattern})$': _schema(shape.named)}
    elif shape.named is not None:
        content['additionalProperties'] = _schema(shape.named)
        if shape.name_pattern != ANY_NAME:
            content['propertyNames'] = {'pattern': f'^{shape.name_pattern}$'}
    if shape.fewest:
        content['minProperties'] = shape.fewest
    return content


def _or_null(schema: dict[str, Any]) -> dict[str, Any]:
    """Let an entry be `null`, which counts as not given."""
    nullable = dict(schema)
    if 'anyOf' in schema:
        nullable['anyOf'] = [*schema['anyOf'], {'type': 'null'}]
    elif 'enum' in schema:
        nullable['enum'] = [*schema['enum'], None]
    elif 'type' in schema:
        kinds = schema['type'] if isinstance(schema['type'], list) else [schema['type']]
        nullable['type'] = [*kinds, 'null']
    return nullable
