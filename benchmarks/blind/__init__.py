# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Blind tests of the diagnosis: an independent simulator, camera and scorer.

Nothing in here imports the package under test: another element, another mesh, another solver,
another renderer. A case is what the workflow sees; its label lies in another folder.
"""
