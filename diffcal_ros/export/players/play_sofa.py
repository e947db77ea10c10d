# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""A scene of SOFA with the body of body.json: `runSofa play_sofa.py` (SofaPython3)."""

import json
from pathlib import Path
from typing import Any

_PLUGINS = [
    'Sofa.Component.Constraint.Projective',
    'Sofa.Component.LinearSolver.Direct',
    'Sofa.Component.Mass',
    'Sofa.Component.ODESolver.Backward',
    'Sofa.Component.SolidMechanics.FEM.Elastic',
    'Sofa.Component.SolidMechanics.FEM.HyperElastic',
    'Sofa.Component.StateContainer',
    'Sofa.Component.Topology.Container.Dynamic',
    'Sofa.Component.Visual',
]


def createScene(root: Any) -> Any:  # noqa: N802 (SOFA looks for this name.)
    """Build the scene under SOFA's root node."""
    body = json.loads(Path(__file__).with_name('body.json').read_text())
    root.gravity = body['gravity']
    root.dt = 0.01
    root.addObject('RequiredPlugin', pluginName=_PLUGINS)
    root.addObject('VisualStyle', displayFlags='showBehaviorModels showForceFields')
    root.addObject('DefaultAnimationLoop')
    node = root.addChild('body')
    node.addObject('EulerImplicitSolver', rayleighStiffness=body['stiffness_damping'])
    node.addObject('SparseLDLSolver', template='CompressedRowSparseMatrixMat3x3d')
    node.addObject(
        'TetrahedronSetTopologyContainer',
        position=body['positions'],
        tetrahedra=body['tetrahedra'],
    )
    node.addObject('TetrahedronSetGeometryAlgorithms', template='Vec3d')
    node.addObject('MechanicalObject', template='Vec3d')
    node.addObject('DiagonalMass', vertexMass=body['vertex_masses'])
    _add_elasticity(node, body)
    node.addObject('FixedProjectiveConstraint', indices=body['held'])
    return root


def _add_elasticity(node: Any, body: dict[str, Any]) -> None:
    if body['is_uniform']:
        node.addObject(
            'TetrahedronHyperelasticityFEMForceField',
            materialName='StVenantKirchhoff',
            ParameterSet=[body['lame_mu'], body['lame_lambda']],
        )
        return
    node.addObject(
        'TetrahedronFEMForceField',
        method='large',
        youngModulus=body['youngs_modulus'],
        poissonRatio=body['poissons_ratio'],
        localStiffnessFactor=body['stiffness_factors'],
    )
