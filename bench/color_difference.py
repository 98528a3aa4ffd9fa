"""CIEDE2000 color differences, and the tone mapping of the render-fidelity goldens.

The tone mapping is three.js' fit to the ACES transforms.
"""
# SPDX-License-Identifier: Apache-2.0
import numpy as np

# Stephen Hill's fit, as three.js has it with exposure 1: x / 0.6, sRGB to its working space, a
# rational curve, and back.
ACES_EXPOSURE = 1.0 / 0.6
ACES_IN = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
ACES_OUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
ACES_TOP, ACES_TOP_0, ACES_BOTTOM_2, ACES_BOTTOM_1, ACES_BOTTOM_0 = 0.0245786, -0.000090537, 0.983729, 0.4329510, 0.238081


def aces_8bit(linear):
    """Encodes (..., 3) linear sRGB radiance as bytes, as the goldens do: a power of 1/2.2, rounded down."""
    c = np.maximum(np.nan_to_num(linear, posinf=1e6), 0.0) * ACES_EXPOSURE @ ACES_IN.T
    c = (c * (c + ACES_TOP) + ACES_TOP_0) / (c * (ACES_BOTTOM_2 * c + ACES_BOTTOM_1) + ACES_BOTTOM_0)
    return np.floor(255.0 * np.clip(c @ ACES_OUT.T, 0.0, 0.9999) ** (1.0 / 2.2)).astype(np.uint8)


def inverse_aces(encoded):
    """Inverts the tone mapping: linear sRGB radiance of unclipped encoded values in [0, 1]."""
    y = np.asarray(encoded, np.float64) ** 2.2 @ np.linalg.inv(ACES_OUT).T
    # y (b2 c^2 + b1 c + b0) = c^2 + t c + t0, the positive root.
    y = np.minimum(y, 0.98 / ACES_BOTTOM_2)
    a, b, c = ACES_BOTTOM_2 * y - 1.0, ACES_BOTTOM_1 * y - ACES_TOP, ACES_BOTTOM_0 * y - ACES_TOP_0
    root = (-b - np.sqrt(np.maximum(b * b - 4.0 * a * c, 0.0))) / (2.0 * a)
    return root @ np.linalg.inv(ACES_IN).T / ACES_EXPOSURE


def ciede2000(lab_a, lab_b):
    """CIE 142-2001, after Sharma, Wu, Dalal: "The CIEDE2000 Color-Difference Formula", Color Res. Appl. 30(1), 2005, whose test
    data the test uses. Arrays (..., 3) of CIELab; parametric weights 1."""
    l1, a1, b1 = np.moveaxis(np.asarray(lab_a, float), -1, 0)
    l2, a2, b2 = np.moveaxis(np.asarray(lab_b, float), -1, 0)
    mean_c7 = ((np.hypot(a1, b1) + np.hypot(a2, b2)) / 2.0) ** 7
    stretch = 1.0 + 0.5 * (1.0 - np.sqrt(mean_c7 / (mean_c7 + 25.0 ** 7)))
    a1, a2 = a1 * stretch, a2 * stretch
    c1, c2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360.0, np.degrees(np.arctan2(b2, a2)) % 360.0
    gray = c1 * c2 == 0.0

    delta_l, delta_c, turn = l2 - l1, c2 - c1, h2 - h1
    turn = np.where(gray, 0.0, np.where(turn > 180.0, turn - 360.0, np.where(turn < -180.0, turn + 360.0, turn)))
    delta_h = 2.0 * np.sqrt(c1 * c2) * np.sin(np.radians(turn / 2.0))

    l, c = (l1 + l2) / 2.0, (c1 + c2) / 2.0
    h = np.where(np.abs(h1 - h2) <= 180.0, (h1 + h2) / 2.0, np.where(h1 + h2 < 360.0, (h1 + h2 + 360.0) / 2.0, (h1 + h2 - 360.0) / 2.0))
    h = np.where(gray, h1 + h2, h)
    t = (1.0 - 0.17 * np.cos(np.radians(h - 30.0)) + 0.24 * np.cos(np.radians(2.0 * h)) + 0.32 * np.cos(np.radians(3.0 * h + 6.0))
         - 0.20 * np.cos(np.radians(4.0 * h - 63.0)))
    rotation = -np.sin(np.radians(60.0 * np.exp(-((h - 275.0) / 25.0) ** 2))) * 2.0 * np.sqrt(c ** 7 / (c ** 7 + 25.0 ** 7))
    dl = delta_l / (1.0 + 0.015 * (l - 50.0) ** 2 / np.sqrt(20.0 + (l - 50.0) ** 2))
    dc, dh = delta_c / (1.0 + 0.045 * c), delta_h / (1.0 + 0.015 * c * t)
    return np.sqrt(np.maximum(dl * dl + dc * dc + dh * dh + rotation * dc * dh, 0.0))
