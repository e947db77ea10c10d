# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The regions of one material each; together they cover the body exactly once."""

from dataclasses import dataclass

from diffcal_ros.scene.model import Quantity, Region
from diffcal_ros.scene.reading.quantities import (
    NAME,
    QUANTITY_RULES,
    quantity_shape,
    read_quantity,
)
from diffcal_ros.scene.reading.section import Section
from diffcal_ros.scene.reading.selections import (
    read_selection,
    select_tets,
    Selection,
    selection_shape,
)
from diffcal_ros.scene.reading.shapes import Flag, Keys
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

IntArray = NDArray[np.int32]

REGIONS_SHAPE = Keys(
    about='the materials; together they cover the body exactly once',
    name_pattern=NAME.pattern,
    fewest=1,
    named=Keys(
        {
            'rest': Flag('all tetrahedra that no other region takes'),
            **selection_shape('tets'),
            **{
                name: quantity_shape(rule, f'{rule.title} in {rule.unit}'.removesuffix(' in '))
                for name, rule in QUANTITY_RULES.items()
            },
        },
        tuple(name for name, rule in QUANTITY_RULES.items() if not rule.may_lack),
    ),
)


@dataclass(frozen=True)
class _Written:
    """One region as written: `selection` is None where it takes what is left."""

    name: str
    section: Section
    selection: Selection | None
    quantities: dict[str, Quantity]


def read_regions(scene: Section, mesh: TetMesh | None) -> tuple[Region, ...]:
    """Read `regions`; without a mesh only what is written is looked at."""
    needed = 'give at least one, {body: {youngs_modulus: .., poissons_ratio: .., density: ..}}'
    if not scene.required('regions', needed):
        return ()
    section = scene.child('regions')
    if section is None:
        return ()
    if not section.names:
        section.problems.add(section.key, f'is empty: {needed}')
    written = [_read_region(section, name) for name in section.names]
    sound = [region for region in written if region is not None]
    if mesh is None or not section.is_sound:
        return ()
    return _assign(section, sound, mesh)


def _read_region(regions: Section, name: str) -> _Written | None:
    if not NAME.fullmatch(name):
        regions.problems.add(
            regions.at(name), 'is no name for a region: use letters, digits and underscores'
        )
    if not regions.has(name):
        regions.wrong(name, 'give youngs_modulus, poissons_ratio and density')
        return None
    section = regions.child(name)
    if section is None:
        return None
    takes_rest = section.flag('rest', default=False)
    selection = read_selection(section, 'tets')
    if takes_rest and (section.has('box') or section.has('tets')):
        section.problems.add(section.key, 'has `rest` and a box or tets: keep one of them')
    read = {
        key: read_quantity(section, key, rule)
        for key, rule in QUANTITY_RULES.items()
        if section.has(key) or not rule.may_lack
    }
    quantities = {key: quantity for key, quantity in read.items() if quantity is not None}
    section.refuse_unknown()
    if not section.is_sound:
        return None
    is_only = len(regions.names) == 1
    if selection is None and not takes_rest and not is_only:
        section.problems.add(
            section.key, 'says not which part of the body it is: give a box, tets or `rest: true`'
        )
        return None
    return _Written(name, section, selection, quantities)


def _assign(regions: Section, written: list[_Written], mesh: TetMesh) -> tuple[Region, ...]:
    """Give each tetrahedron to one region, or note why that fails."""
    leftover = [region for region in written if region.selection is None]
    if len(leftover) > 1:
        regions.problems.add(
            leftover[1].section.key,
            f'has `rest: true`, as `{leftover[0].name}` has: only one region takes what is left',
        )
    owner = np.full(mesh.tet_count, -1)
    for number, region in enumerate(written):
        if region.selection is None:
            continue
        tets = select_tets(region.selection, mesh)
        taken = tets[owner[tets] >= 0]
        if len(taken):
            regions.problems.add(
                region.section.key,
                f'shares {len(taken)} tetrahedra with `{written[owner[taken[0]]].name}` '
                f'(first: {taken[0]}): make the regions disjoint',
            )
        owner[tets] = number
    return _cover(regions, written, owner, mesh)


def _cover(
    regions: Section, written: list[_Written], owner: NDArray[np.int_], mesh: TetMesh
) -> tuple[Region, ...]:
    free = np.flatnonzero(owner < 0)
    leftover = [number for number, region in enumerate(written) if region.selection is None]
    if leftover:
        owner[free] = leftover[0]
        if not len(free):
            regions.problems.add(
                written[leftover[0]].section.key,
                'has no tetrahedron: the other regions take the whole body, so remove it',
            )
    elif len(free):
        centroid = ', '.join(f'{value:.4g}' for value in mesh.centroids[free[0]])
        regions.problems.add(
            regions.key,
            f'leave out {len(free)} of {mesh.tet_count} tetrahedra (the first at {centroid} m): '
            'widen a box or give one region `rest: true`',
        )
    if not regions.is_sound:
        return ()
    return tuple(
        Region(
            name=region.name,
            tets=np.flatnonzero(owner == number).astype(np.int32),
            youngs_modulus=region.quantities['youngs_modulus'],
            poissons_ratio=region.quantities['poissons_ratio'],
            density=region.quantities['density'],
            damping=region.quantities.get('damping'),
        )
        for number, region in enumerate(written)
    )
