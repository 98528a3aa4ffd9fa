// Evaluation of procedural textures: averages over points of a footprint.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/procedural_texture.h"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace kindling {
namespace {

Float4 to_float4(const V4f& v) { return Float4{v.x, v.y, v.z, v.w}; }

float length3(const V4f& v) { return std::sqrt(v.x * v.x + v.y * v.y + v.z * v.z); }

// Clamps to the range of texels. Colors and factors are not negative; 65504 is the largest half.
float in_range(float x) { return x > 0.0f ? std::min(x, 65504.0f) : 0.0f; }

// Returns point k of a Hammersley set of 4 or 16 points in [0, 1)^2, with one point in each row,
// column and square of a grid.
V2f hammersley(int k, int count) {
  int reversed = 0;
  for (int bit = 1, other = count >> 1; bit < count; bit <<= 1, other >>= 1)
    if ((k & bit) != 0) reversed |= other;
  const float step = 1.0f / static_cast<float>(count);
  return {static_cast<float>(k) * step, static_cast<float>(reversed) * step};
}

float wrapped(float x) { return x - std::floor(x); }

} // namespace

int ProceduralTextureView::point_count(std::span<const ProceduralSample> samples) const {
  if (program.filters_itself) return 1;
  assert(samples.size() >= streams.size());
  float features = 0.0f; // along the longer axis
  for (const size_t axis : {size_t{0}, size_t{1}}) {
    float along = 0.0f;
    for (size_t s = 0; s < streams.size(); ++s) along += length3(samples[s].across[axis]) * program.frequencies[s];
    features = std::max(features, along);
  }
  return features < 0.125f ? 1 : features < 0.4f ? 4 : 16;
}

V4f ProceduralTextureView::evaluate(std::span<const ProceduralSample> samples, std::span<const TextureView> textures,
                                    const V2f& shift, int max_points) const {
  assert(samples.size() >= streams.size() && streams.size() <= kProceduralStreams);
  std::array<Float4, kProceduralStreams> values;
  std::array<std::array<Float4, 2>, kProceduralStreams> across;
  bool filtered = false;
  for (size_t s = 0; s < streams.size(); ++s) {
    values[s] = to_float4(samples[s].value);
    for (const size_t axis : {size_t{0}, size_t{1}}) {
      across[s][axis] = to_float4(samples[s].across[axis]);
      filtered |= length3(samples[s].across[axis]) > 0.0f;
    }
  }
  const int count = filtered ? std::min(point_count(samples), max_points) : 1;
  Float4 sum = {0.0f, 0.0f, 0.0f, 0.0f};
  for (int k = 0; k < count; ++k) {
    ProceduralPoint point{
        .values = values, .across = across, .scale = filtered ? 1.0f / std::sqrt(static_cast<float>(count)) : 0.0f};
    std::array<Float4, kProceduralStreams> moved;
    if (count > 1) {
      const V2f at = hammersley(k, count) + shift;
      const float x = wrapped(at.x) - 0.5f, y = wrapped(at.y) - 0.5f;
      for (size_t s = 0; s < streams.size(); ++s) moved[s] = values[s] + across[s][0] * x + across[s][1] * y;
      point.values = moved;
    }
    sum += run(program, point, textures);
  }
  sum /= static_cast<float>(count);
  switch (channels) {
  case 4: return {in_range(sum[0]), in_range(sum[1]), in_range(sum[2]), in_range(sum[3])};
  case 2: return {in_range(sum[0]), in_range(sum[1]), 0.0f, 1.0f};
  default: return {in_range(sum[0]), in_range(sum[1]), in_range(sum[2]), 1.0f};
  }
}

} // namespace kindling
