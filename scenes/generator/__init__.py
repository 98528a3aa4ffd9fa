# SPDX-License-Identifier: Apache-2.0
"""What scenes/generate.py is made of: one module per scene, and the writers they share."""
