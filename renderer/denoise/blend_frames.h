// Blending of noisy frames of an animation along their motion, against flicker after denoising.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <span>
#include <vector>

namespace kindling {

// A frame of an animation, by rows from the top. All frames of a call have the same size.
struct NoisyFrame {
  V2i size_px{0, 0};
  std::span<const float> rgba;   // four floats per pixel, linear, premultiplied
  std::span<const float> albedo; // three floats per pixel, 0 to 1; empty: none
  std::span<const float> normal; // three floats per pixel, unit or shorter; empty: none
  // Four floats per pixel: the position in the previous frame minus that in this one, then that in
  // this one minus that in the next; in pixels, x to the right, y upwards (Aov::vector).
  std::span<const float> motion;
  std::span<const float> samples; // one float per pixel: the number of its samples; empty: all the same
};

struct BlendedFrame {
  std::vector<float> rgba;
  double mean_frames = 1.0; // that a pixel is made of, this one included
};

// Adds to each pixel of `frames[center]` the pixels of the other frames, which are in the order of
// time, that show the same point of a surface, weighted by their samples. The color of a pixel of
// another frame counts
// - if the motion leads there and back again: else the point is hidden in one of the two;
// - the less, the more albedo, normal and alpha differ: in a mirror or behind glass they are those
//   of what is seen there, which the motion of the mirror does not follow;
// - not where the colors around it differ by more than their noise does: shadows and highlights
//   that move (a paired t-test of 9 x 9 pixels).
// Pixels are taken whole, without interpolation: noise stays independent from pixel to pixel, as
// denoisers expect it. Their colors are divided by their albedo and multiplied by that of the
// frame, so that textures do not shift. Pixels without a normal show no surface and no noise: they
// and alpha stay as they are. Values that are not finite are neither taken nor replaced.
[[nodiscard]] BlendedFrame blend_frames(std::span<const NoisyFrame> frames, size_t center);

} // namespace kindling
