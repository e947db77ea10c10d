# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""Pages in the browser: a fit over what was measured, and a scene that is set up by hand."""
