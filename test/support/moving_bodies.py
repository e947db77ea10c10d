# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Small bodies that are let go, with nothing symmetric about them."""

from dataclasses import dataclass, replace
from typing import Any

from diffcal_ros.damping import Damping
from diffcal_ros.fem.elements.element import Element
from diffcal_ros.fem.motion.inputs import HeldMotion, MotionChange, Release
from diffcal_ros.fem.motion.moving_body import Motion, MovingBody
from diffcal_ros.fem.terms.conditions import Conditions, NO_CONDITIONS
from diffcal_ros.material import Material
import numpy as np

from support.beams import beam_mesh
from support.bodies import GRAVITY, hanging_beam, uniform_material

RELEASE_TIME = 0.0123


@dataclass(frozen=True)
class Case:
    """A body with everything that its motion depends on."""

    body: MovingBody
    material: Material
    damping: Damping
    gravity: np.ndarray
    stamps: np.ndarray
    release_time: float = RELEASE_TIME
    conditions: Conditions = NO_CONDITIONS
    held_motion: HeldMotion | None = None
    rungs: tuple[int, ...] | None = None

    def run(self, **more: Any) -> Motion:
        """Simulate, with what else `MovingBody.simulate` takes."""
        return self.body.simulate(
            self.material,
            self.damping,
            self.gravity,
            self.stamps,
            held_motion=self.held_motion,
            conditions=self.conditions,
            release_time=self.release_time,
            rungs=self.rungs,
            **more,
        )

    def moved(self, change: MotionChange, step: float) -> 'Case':
        """Return the case after a step along a change; effects stay as they are."""

        def plus(values: np.ndarray, direction: np.ndarray | None) -> np.ndarray:
            return values if direction is None else values + step * direction

        material = self.material
        return replace(
            self,
            material=replace(
                material,
                youngs_modulus=plus(material.youngs_modulus, change.youngs_modulus),
                poissons_ratio=plus(material.poissons_ratio, change.poissons_ratio),
                density=plus(material.density, change.density),
            ),
            damping=Damping(
                plus(self.damping.strain_rate, change.damping),
                self.damping.mass + step * change.mass_damping,
            ),
            gravity=plus(self.gravity, change.gravity),
            release_time=self.release_time + step * change.release_time,
        )


def released_beam(
    element: Element,
    random: np.random.Generator,
    *,
    integrator: str = 'implicit',
    time_step: float | None = None,
    tolerance: float | None = None,
    counts: tuple[int, int, int] = (6, 2, 2),
) -> Case:
    """A beam held at its low-x end, let go at its other end."""
    mesh = beam_mesh(counts)
    count = mesh.tet_count
    support = np.flatnonzero(mesh.rest_positions[:, 0] > 0.11).astype(np.int32)
    body = MovingBody(
        hanging_beam(element, mesh),
        Release(support, RELEASE_TIME),
        integrator=integrator,
        time_step=time_step,
        tolerance=tolerance,
    )
    return Case(
        body=body,
        material=Material(
            youngs_modulus=40e3 * (1.0 + random.random(count)),
            poissons_ratio=0.40 + 0.05 * random.random(count),
            density=1000.0 * (1.0 + random.random(count)),
        ),
        damping=Damping(20.0 * (1.0 + random.random(count)), 0.3),
        gravity=GRAVITY,
        stamps=np.array([0.005, 0.03, 0.071, 0.153]),
    )


def shaken_beam(integrator: str = 'implicit', time_step: float | None = None) -> Case:
    """A clamp that is shaken smoothly: no shock excites what no step follows."""
    mesh = beam_mesh((4, 1, 1))
    body = hanging_beam(Element.LINEAR, mesh)
    held = mesh.rest_positions[body.held_vertices]
    count = mesh.tet_count

    def shaken(time: float) -> np.ndarray:
        share = np.clip(time / 0.12, 0.0, 1.0)
        return held + np.array([0.0, 0.01, -0.02]) * share**4 * (
            35 - 84 * share + 70 * share**2 - 20 * share**3
        )

    return Case(
        body=MovingBody(body, None, integrator=integrator, time_step=time_step),
        material=uniform_material(mesh, 40e3, 0.40),
        damping=Damping(np.full(count, 15.0), 0.2),
        gravity=GRAVITY,
        stamps=np.array([0.117, 0.2]),
        release_time=0.0,
        held_motion=shaken,
    )


def directions(case: Case, random: np.random.Generator) -> dict[str, MotionChange]:
    """One uneven direction for every kind of parameter."""
    material, count = case.material, len(case.material.density)
    return {
        'youngs_modulus': MotionChange(
            youngs_modulus=material.youngs_modulus * random.random(count)
        ),
        'poissons_ratio': MotionChange(poissons_ratio=0.1 * random.random(count)),
        'density': MotionChange(density=material.density * random.random(count)),
        'gravity': MotionChange(gravity=np.array([2.0, 1.0, -4.0])),
        'damping': MotionChange(damping=case.damping.strain_rate * random.random(count)),
        'mass_damping': MotionChange(mass_damping=1.0),
        'release_time': MotionChange(release_time=0.01),
    }
