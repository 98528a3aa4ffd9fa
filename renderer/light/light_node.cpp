// Quantizes families of emitters to the lanes of a node.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/light_node.h"

#include <cassert>

namespace kindling {

namespace {

constexpr float kCenterError = 0.8661f;          // in steps: half a step along each axis
constexpr float kRelativeError = 4e-7f;          // of coordinates: differences of positions are rounded
constexpr float kAxisError = 0.0069f;            // of a cosine: half of 1/127 along each axis
constexpr float kMaxRadiusSteps = 255.0f - 1.0f; // maximum radius in steps before it is rounded up

// Returns x rounded and clamped; `low` for NaN.
long rounded(float x, float low, float high) { return std::lround(std::min(std::max(low, x), high)); }
uint8_t unsigned_byte(float value) { return static_cast<uint8_t>(rounded(value * 255.0f, 0.0f, 255.0f)); }
int8_t signed_byte(float value) { return static_cast<int8_t>(rounded(value * 127.0f, -127.0f, 127.0f)); }

// Returns the upper bits; never 0 for positive values.
uint16_t upper_bits(float value) {
  const uint32_t bits = std::bit_cast<uint32_t>(std::clamp(value, 1e-15f, 2.0f));
  return static_cast<uint16_t>((bits + 0x4000U) >> 15);
}

} // namespace

void LightNode::store(std::span<const LightFamily> families) {
  assert(!families.empty() && families.size() <= kWidth);
  Box3f centers;
  float largest_radius = 0.0f;
  float largest_coordinate = 0.0f;
  for (const LightFamily& f : families) {
    centers.extendBy(f.center);
    largest_radius = std::max(largest_radius, f.radius);
    for (int axis = 0; axis < 3; ++axis) largest_coordinate = std::max(largest_coordinate, std::fabs(f.center[axis]));
  }
  const float rounding = kRelativeError * largest_coordinate;
  const float extent = max_component(centers.max - centers.min);
  step = std::max({extent / 255.0f, (largest_radius + rounding) / (kMaxRadiusSteps - kCenterError), 1e-18f});
  for (int axis = 0; axis < 3; ++axis) origin[axis] = centers.min[axis];
  const auto place = [&](const V3f& center, int axis) {
    return static_cast<uint8_t>(rounded((center[axis] - origin[axis]) / step, 0.0f, 255.0f));
  };
  for (uint32_t i = 0; i < kWidth; ++i) {
    const bool used = i < families.size();
    const LightFamily f = used ? families[i] : LightFamily{.center = centers.min};
    x[i] = place(f.center, 0);
    y[i] = place(f.center, 1);
    z[i] = place(f.center, 2);
    radius[i] = static_cast<uint8_t>(rounded(std::ceil((f.radius + rounding) / step + kCenterError), 1.0f, 255.0f));
    axis_x[i] = signed_byte(f.axis.x);
    axis_y[i] = signed_byte(f.axis.y);
    axis_z[i] = signed_byte(f.axis.z);
    // -128 is below any cosine, including that of a rounded axis (up to 1.007).
    const float reach = std::floor((f.cos_reach - kAxisError) * 127.0f);
    cos_reach[i] = reach >= -126.0f ? static_cast<int8_t>(std::min(reach, 127.0f)) : int8_t{-128};
    odd[i] = unsigned_byte(f.odd);
    flat[i] = unsigned_byte(f.flat);
    even[i] = used ? upper_bits(f.even) : uint16_t{0};
  }
}

} // namespace kindling
