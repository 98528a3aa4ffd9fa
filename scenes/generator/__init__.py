# SPDX-License-Identifier: Apache-2.0
"""Modules of scenes/generate.py: one per scene, and shared writers."""
