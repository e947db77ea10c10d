# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Patches of one kind in one view, and which of them are kept for the report or left out."""

from collections.abc import Sequence, Set
from dataclasses import dataclass, replace

from diffcal_ros.calibration.observations.observation import Observation
from diffcal_ros.diagnosis.patches.patches import cell_places, Patches
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
BoolArray = NDArray[np.bool_]
PatchName = tuple[int, str, int]  # View, kind and cell.
FullName = tuple[int, str, bool, int]  # And whether it shows the fixture.
Rows = dict[FullName, FloatArray]  # One row of columns for each patch, by its name.

# Times the usual residual of a view.
_STRANGE = 8.0
_MOST, _MOST_SIGMAS = 0.8, 1.28


@dataclass(frozen=True)
class PatchGroup:
    """Patches of one kind in one view, with what the mesh may add to them.

    Attributes:
        view: number of the observation.
        kind: `depth` or `edge`.
        recording: number of the first view of its recording; its views share errors.
        patches: residuals and Jacobian; the mesh's expected error is taken off.
        mesh: what the mesh's error adds to the values, one standard deviation [m], shape (n,).
        is_report: which patches are kept for the report, shape (n,).
        is_rigid: whether they show the fixture, not the body.
    """

    view: int
    kind: str
    recording: int
    patches: Patches
    mesh: FloatArray
    is_report: BoolArray
    is_rigid: bool = False

    def chosen(self, kept: BoolArray) -> 'PatchGroup':
        """Return some of its patches, shape (n,); none may be left."""
        return replace(
            self,
            patches=self.patches.chosen(kept),
            mesh=self.mesh[kept],
            is_report=self.is_report[kept],
        )


def of_the_body(groups: Sequence[PatchGroup]) -> list[PatchGroup]:
    """Return the groups that show the body, not the fixture."""
    return [group for group in groups if not group.is_rigid]


def moved(groups: Sequence[PatchGroup], step: FloatArray) -> list[PatchGroup]:
    """Return the patches after a step of the parameters, to first order, shape (k,)."""
    count = len(step)
    return [
        replace(own, patches=replace(p, values=p.values - p.jacobian[:, :count] @ step))
        for own in groups
        for p in (own.patches,)
    ]


def counted_after(groups: Sequence[PatchGroup], step: FloatArray) -> list[PatchGroup]:
    """Return patches counted by how far off a step of all columns leaves them, shape (k,)."""
    return [
        replace(own, patches=replace(p, left=p.values - p.jacobian @ step))
        for own in groups
        for p in (own.patches,)
    ]


def with_columns(groups: Sequence[PatchGroup], columns: Sequence[FloatArray]) -> list[PatchGroup]:
    """Return patches with further columns behind their tangents, shape (n, m) for each group."""
    return [
        replace(b, patches=replace(b.patches, jacobian=np.hstack([b.patches.jacobian, own])))
        for b, own in zip(groups, columns, strict=True)
    ]


def rows_of(groups: Sequence[PatchGroup], columns: Sequence[FloatArray]) -> Rows:
    """Return columns of groups, shape (n, m) each, by the names of their patches."""
    return {
        name: row
        for group, own in zip(groups, columns, strict=True)
        for name, row in zip(full_names([group]), own, strict=True)
    }


def columns_of(rows: Rows, groups: Sequence[PatchGroup]) -> list[FloatArray]:
    """Return columns of the patches of groups; what was not seen before does not move, (n, m)."""
    width = len(next(iter(rows.values()), ()))
    nothing = np.zeros(width)
    return [
        np.array([rows.get(name, nothing) for name in full_names([group])]).reshape(
            len(group.patches.values), width
        )
        for group in groups
    ]


def report_part(observation: Observation, cells: NDArray[np.int64]) -> BoolArray:
    """Tell which patches are kept for the report: whole frames of a motion, else cells."""
    if observation.instant is not None:
        return np.full(len(cells), observation.is_held_out)
    rows, columns = cell_places(cells)
    # Every second cell of every second row: none touches another.
    found: BoolArray = (rows % 2 == 0) & (columns % 2 == 0)
    return found


def strange_patches(groups: Sequence[PatchGroup]) -> frozenset[PatchName]:
    """Return patches so far off the rest of their view that they show something else.

    Where a clamp or a cable covers the body, its edge is found in place of the body's. A model
    that lacks an effect is off in many patches, and none of them is strange then.
    """
    found: set[PatchName] = set()
    bodies = of_the_body(groups)
    for view in dict.fromkeys(group.view for group in bodies):
        own = [group for group in bodies if group.view == view]
        sizes = [_sizes(group) for group in own]
        # A quantile that a fault of a fifth of the body already moves.
        usual = max(1.0, float(np.quantile(np.concatenate(sizes), _MOST)) / _MOST_SIGMAS)
        for group, size in zip(own, sizes, strict=True):
            cells = group.patches.cells[size > _STRANGE * usual]
            found.update((view, group.kind, int(cell)) for cell in cells)
    return frozenset(found)


def names_of(groups: Sequence[PatchGroup]) -> list[PatchName]:
    """Return the names of all patches, in the order of the groups."""
    return [(own.view, own.kind, int(cell)) for own in groups for cell in own.patches.cells]


def full_names(groups: Sequence[PatchGroup]) -> list[FullName]:
    """Return the names of all patches, the fixture's apart from the body's, in their order."""
    return [
        (own.view, own.kind, own.is_rigid, int(cell))
        for own in groups
        for cell in own.patches.cells
    ]


def only(groups: Sequence[PatchGroup], names: Set[FullName]) -> list[PatchGroup]:
    """Return the patches that have one of some names; groups may be left with none."""
    found = []
    for group in groups:
        own = np.array([name in names for name in full_names([group])], dtype=bool)
        found.append(group.chosen(own))
    return found


def _sizes(group: PatchGroup) -> FloatArray:
    """Return residuals in units of their noise, shape (n,)."""
    noise = group.patches.variances + group.mesh**2
    return np.asarray(np.abs(group.patches.values) / np.sqrt(noise))
