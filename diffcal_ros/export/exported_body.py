# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""What every simulator needs to know of a body: mesh, clamp, material, gravity."""

from dataclasses import dataclass, replace
from functools import cached_property

from diffcal_ros.errors import InputError
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.material import lame_lambda, lame_mu, Material
from diffcal_ros.scene.body_plan import plan_body
from diffcal_ros.scene.model import ObservationSetup, Scene
from diffcal_ros.scene.start_material import start_constant, start_material
from diffcal_ros.tet_mesh import TetMesh
import numpy as np
from numpy.typing import NDArray

FloatArray = NDArray[np.float64]
IntArray = NDArray[np.int32]


@dataclass(frozen=True)
class ExportedBody:
    """A body at rest in its clamp, world frame, SI units.

    Moduli are what a small stretch measures, whatever the scene's law and convention are.

    Attributes:
        name: of the scene.
        mesh: vertices at rest in the world frame [m].
        element: that the scene simulates it with.
        law: name of the scene's energy law.
        held: vertices that the clamp holds for good, ascending, shape (h,).
        held_positions: where it holds them [m], shape (h, 3).
        gravity: acceleration [m/s^2], shape (3,).
        youngs_modulus: of each tetrahedron [Pa], shape (T,).
        poissons_ratio: shape (T,).
        density: [kg/m^3], shape (T,).
        damping: by the rate of strain, see `damping.Damping` [Pa s], shape (T,).
        region: number of each tetrahedron's region, shape (T,).
        region_names: as in the scene.
        region_moduli: of each region [Pa], which a field varies.
        notes: what of the scene the asset does not have, in sentences.
    """

    name: str
    mesh: TetMesh
    element: Element
    law: str
    held: IntArray
    held_positions: FloatArray
    gravity: FloatArray
    youngs_modulus: FloatArray
    poissons_ratio: FloatArray
    density: FloatArray
    damping: FloatArray
    region: IntArray
    region_names: tuple[str, ...]
    region_moduli: tuple[float, ...]
    notes: tuple[str, ...] = ()

    @property
    def volume(self) -> float:
        """Of the body at rest [m^3]."""
        return float(self.mesh.volumes.sum())

    @property
    def mass(self) -> float:
        """Of the whole body, held parts included [kg]."""
        return float(self.vertex_masses.sum())

    @cached_property
    def vertex_masses(self) -> FloatArray:
        """A quarter of each tetrahedron's mass at each of its corners [kg], shape (V,)."""
        masses = np.zeros(self.mesh.vertex_count)
        quarters = np.repeat(0.25 * self.density * self.mesh.volumes, 4)
        np.add.at(masses, self.mesh.tets.reshape(-1), quarters)
        return masses

    @property
    def lame_mu(self) -> FloatArray:
        """Shear modulus at rest [Pa], shape (T,)."""
        return lame_mu(self.youngs_modulus, self.poissons_ratio)

    @property
    def lame_lambda(self) -> FloatArray:
        """Lame's other number at rest [Pa], shape (T,)."""
        return lame_lambda(self.youngs_modulus, self.poissons_ratio)

    @property
    def stiffness_damping(self) -> FloatArray:
        """Rayleigh's factor on the stiffness, for simulators that damp by it [s], shape (T,).

        It takes the same power out of a slender body that is pulled or bent, where a strain rate
        e comes with -nu e across: beta / 2 (1 + 2 nu^2) e^2 is ours, factor / 2 E e^2 Rayleigh's.
        In shear the factor would be beta (1 + nu) / E, the same where nu is 0.5.
        """
        return self.damping / self.damping_of_stiffness

    @property
    def damping_of_stiffness(self) -> FloatArray:
        """Damping by the rate of strain that is one second of Rayleigh's [Pa], shape (T,)."""
        return np.asarray(self.youngs_modulus / (1.0 + 2.0 * self.poissons_ratio**2))


def exported_body(scene: Scene, setup: ObservationSetup) -> ExportedBody:
    """Return a scene's body by its start values, as one of its observations holds it.

    Raises:
        InputError: when nothing holds the body for good.
    """
    region = np.empty(scene.mesh.tet_count, dtype=np.int32)
    for number, own in enumerate(scene.regions):
        region[own.tets] = number
    material = start_material(replace(scene, relative_modulus=None))
    modulus, ratio = constants_at_rest(material)
    moduli = tuple(float(modulus[own.tets[0]]) for own in scene.regions)
    if scene.relative_modulus is not None:
        modulus = modulus * scene.relative_modulus
    if not setup.staying:
        raise InputError(
            f'nothing holds the body of {setup.name!r} once it is let go: an asset needs a clamp '
            'that stays'
        )
    plan = plan_body(scene, setup)
    where = np.searchsorted(plan.held.vertices, plan.staying.vertices)
    return ExportedBody(
        name=scene.name,
        mesh=plan.mesh,
        element=scene.element,
        law=scene.law,
        held=plan.staying.vertices,
        held_positions=plan.held.positions[where],
        gravity=setup.gravity,
        youngs_modulus=modulus,
        poissons_ratio=ratio,
        density=material.density,
        damping=start_constant(scene, 'damping'),
        region=region,
        region_names=tuple(own.name for own in scene.regions),
        region_moduli=moduli,
        notes=_left_out(scene, setup),
    )


def constants_at_rest(material: Material) -> tuple[FloatArray, FloatArray]:
    """Return Young's modulus [Pa] and Poisson's ratio that a small stretch measures, shape (T,).

    With the consistent convention these are the material's own. The plain Lame parameters of the
    other one are undone as Smith et al. 2018, section 3.4, puts them in.
    """
    lame, conversion = material.lame_parameters(), material.conversion
    mu = lame.neo_hookean_mu / conversion.mu
    lam = lame.neo_hookean_lambda - conversion.added * mu
    return mu * (3.0 * lam + 2.0 * mu) / (lam + mu), lam / (2.0 * (lam + mu))


def _left_out(scene: Scene, setup: ObservationSetup) -> tuple[str, ...]:
    notes = []
    if any(part.turn is not None for part in setup.staying):
        notes.append(
            'the clamp turns from rest to where it was filmed: the asset starts at rest, and its '
            'clamp stays there unless the target says otherwise'
        )
    if scene.cables:
        names = ', '.join(cable.name for cable in scene.cables)
        notes.append(f'cables ({names}) are not exported: add them in the simulator')
    if scene.effects:
        notes.append(
            f'effects ({", ".join(sorted(scene.effects))}) are not exported: the asset is the '
            'body alone'
        )
    return tuple(notes)
