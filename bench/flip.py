"""LDR-FLIP: the difference of two images that a viewer sees when flipping between them.

The error of a pixel is between 0 (equal) and 1.

Andersson, Nilsson, Akenine-Moller, Oskarsson, Astrom, Fairchild: "FLIP: A Difference Evaluator for Alternating Images", Proc.
ACM Comput. Graph. Interact. Tech. 3(2), 2020. Section numbers below are that paper's. Written from its formulas; all of its
filters are sums of products of one-dimensional ones, so they are applied by rows and columns.
"""
# SPDX-License-Identifier: Apache-2.0
import numpy as np

PIXELS_PER_DEGREE = 67.0  # 0.7 m from a 0.7 m wide screen of 3840 pixels (section 5)
COLOR_EXPONENT, COLOR_KNEE, COLOR_KNEE_VALUE = 0.7, 0.4, 0.95  # q_c, p_c, p_t (section 4.1.2)
FEATURE_WIDTH_DEG, FEATURE_EXPONENT = 0.082, 0.5  # w (section 4.2.1), q_f (4.2.2)
# Contrast sensitivity: weights and widths (a_i, b_i) of Gaussians, one row a channel: luminance,
# red-green, blue-yellow (section 4.1.1, table 1).
CONTRAST = [[(1.0, 0.0047)], [(1.0, 0.0053)], [(34.1, 0.04), (13.5, 0.025)]]
# Linear sRGB to XYZ with the exact sums of its rows as white point (D65).
RGB_TO_XYZ = np.array([[10135552 / 24577794, 8788810 / 24577794, 4435075 / 24577794],
                       [2613072 / 12288897, 8788810 / 12288897, 887015 / 12288897],
                       [1425312 / 73733382, 8788810 / 73733382, 70074185 / 73733382]])
WHITE = RGB_TO_XYZ.sum(axis=1)


def flip(reference, test, pixels_per_degree=PIXELS_PER_DEGREE):
    """The error map of two images of one size: arrays (height, width, 3) of sRGB-encoded values in [0, 1]."""
    opponent = [rgb_to_opponent(srgb_to_linear(np.asarray(p, np.float64))) for p in (reference, test)]
    color = color_difference(*opponent, pixels_per_degree)
    feature = feature_difference(*((p[..., 0] + 16.0) / 116.0 for p in opponent), pixels_per_degree)
    return color ** (1.0 - feature)  # section 4.3


def color_difference(reference, test, pixels_per_degree):
    """Section 4.1, in [0, 1], of images in opponent space."""
    adjusted = [hunt(linear_to_lab(np.clip(opponent_to_rgb(contrast_filter(p, pixels_per_degree)), 0.0, 1.0)))
                for p in (reference, test)]
    largest = largest_color_difference()
    error = hyab(*adjusted) ** COLOR_EXPONENT
    knee = COLOR_KNEE * largest
    return np.where(error < knee, COLOR_KNEE_VALUE / knee * error,
                    COLOR_KNEE_VALUE + (error - knee) / (largest - knee) * (1.0 - COLOR_KNEE_VALUE))


def largest_color_difference():
    """Distance of green and blue, the largest within sRGB (section 4.1.2)."""
    green, blue = (hunt(linear_to_lab(np.array(c, float))) for c in ((0, 1, 0), (0, 0, 1)))
    return float(hyab(green, blue)) ** COLOR_EXPONENT


def feature_difference(reference, test, pixels_per_degree):
    """Section 4.2, in [0, 1], of luminances in [0, 1]: edges and points that only one image has."""
    deviation = 0.5 * FEATURE_WIDTH_DEG * pixels_per_degree
    x = np.arange(-np.ceil(3.0 * deviation), np.ceil(3.0 * deviation) + 1.0)
    gauss = np.exp(-x * x / (2.0 * deviation * deviation))
    first, second = signed_unit(-x * gauss), signed_unit((x * x / (deviation * deviation) - 1.0) * gauss)
    gauss /= gauss.sum()
    differences = [np.abs(np.hypot(filtered(test, gauss, kernel), filtered(test, kernel, gauss)) -
                          np.hypot(filtered(reference, gauss, kernel), filtered(reference, kernel, gauss)))
                   for kernel in (first, second)]
    return np.clip((np.maximum(*differences) / np.sqrt(2.0)) ** FEATURE_EXPONENT, 0.0, 1.0)


def signed_unit(kernel):
    """Positive weights that sum to 1 and negative ones that sum to -1."""
    return np.where(kernel > 0, kernel / kernel[kernel > 0].sum(), kernel / -kernel[kernel < 0].sum())


def contrast_filter(opponent, pixels_per_degree):
    """Filters each channel by contrast sensitivity (section 4.1.1)."""
    widest = max(b for channel in CONTRAST for _, b in channel)
    radius = np.ceil(3.0 * np.sqrt(widest / (2.0 * np.pi ** 2)) * pixels_per_degree)
    x = np.arange(-radius, radius + 1.0) / pixels_per_degree
    result = np.empty_like(opponent)
    for channel, terms in enumerate(CONTRAST):
        kernels = [(a * np.sqrt(np.pi / b), np.exp(-np.pi ** 2 * x * x / b)) for a, b in terms]
        total = sum(weight * kernel.sum() ** 2 for weight, kernel in kernels)
        result[..., channel] = sum(weight / total * filtered(opponent[..., channel], kernel, kernel) for weight, kernel in kernels)
    return result


def filtered(image, down, across):
    """A separable correlation; beyond the border the outermost pixels continue."""
    for axis, kernel in ((0, down), (1, across)):
        radius = len(kernel) // 2
        padded = np.pad(image, [(radius, radius) if a == axis else (0, 0) for a in (0, 1)], mode="edge")
        size = image.shape[axis]
        result = np.zeros_like(image)
        for offset, weight in enumerate(kernel):
            if weight != 0.0:
                result += weight * (padded[offset:offset + size] if axis == 0 else padded[:, offset:offset + size])
        image = result
    return image


def srgb_to_linear(value):
    return np.where(value > 0.04045, ((value + 0.055) / 1.055) ** 2.4, value / 12.92)


def rgb_to_opponent(rgb):
    """Y_y C_x C_z (section 4.1.1): CIELab without its cube root."""
    x, y, z = np.moveaxis(rgb @ RGB_TO_XYZ.T / WHITE, -1, 0)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def opponent_to_rgb(opponent):
    luminance, x, z = np.moveaxis(opponent, -1, 0)
    y = (luminance + 16.0) / 116.0
    return (np.stack([y + x / 500.0, y, y - z / 200.0], axis=-1) * WHITE) @ np.linalg.inv(RGB_TO_XYZ).T


def linear_to_lab(rgb):
    """CIELab of linear sRGB, D65."""
    t = rgb @ RGB_TO_XYZ.T / WHITE
    delta = 6.0 / 29.0
    x, y, z = np.moveaxis(np.where(t > delta ** 3, np.cbrt(t), t / (3.0 * delta * delta) + 4.0 / 29.0), -1, 0)
    return np.stack([116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)], axis=-1)


def hunt(lab):
    """Colorfulness grows with luminance (section 4.1.2)."""
    return np.concatenate([lab[..., :1], 0.01 * lab[..., :1] * lab[..., 1:]], axis=-1)


def hyab(a, b):
    """Distance for large color differences (Abasi and others 2020): city-block in lightness, Euclidean in the rest."""
    return np.abs(a[..., 0] - b[..., 0]) + np.hypot(a[..., 1] - b[..., 1], a[..., 2] - b[..., 2])
