// Area-preserving maps from the unit square to apertures.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/aperture.h"

#include "renderer/base/hash.h"
#include "renderer/sampling/warp.h"

#include <bit>
#include <cassert>

namespace kindling {
namespace {

// The barrel leaves more than a third of a disk and a fifth of a triangle, so longer runs of misses
// are impossible in practice.
constexpr int kMaxTries = 128;

// A point of the square as a ring around its center: the ring's relative size and a position along
// it, both uniform by area (Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square",
// without the circle).
struct Ring {
  float size;     // in [0, 1]
  float position; // in [0, 1), turns from +x of the point's image on a disk
};

Ring ring_of(const V2f& u) {
  const float x = 2.0f * u.x - 1.0f;
  const float y = 2.0f * u.y - 1.0f;
  const bool wide = std::abs(x) > std::abs(y);
  const float size = wide ? x : y;
  if (size == 0.0f) return {0.0f, 0.0f};
  float position = wide ? 0.125f * y / x : 0.25f - 0.125f * x / y;
  if (size < 0.0f) position += 0.5f;
  if (position < 0.0f) position += 1.0f;
  return {std::abs(size), std::min(position, kOneMinusEpsilon)};
}

} // namespace

Aperture::Aperture(const CameraLens& lens, float radius_m)
    : radius_(radius_m), width_over_height_(1.0f / lens.anamorphic_ratio), cats_eye_(lens.cats_eye),
      blades_(lens.aperture_blades >= 3 ? lens.aperture_blades : 0) {
  if (blades_ == 0) return;
  // Removes whole turns, so that sincos_turns() keeps its accuracy.
  first_corner_ = static_cast<float>(std::remainder(0.25 + lens.aperture_rotation_rad * (0.5 / std::numbers::pi), 1.0));
  const SinCos step = sincos_turns(1.0f / static_cast<float>(blades_));
  step_cos_ = step.cos;
  step_sin_ = step.sin;
  inner_radius_ = sincos_turns(0.5f / static_cast<float>(blades_)).cos;
}

// Triangles from the center to each edge have equal areas, and a ring cuts the same fraction of
// each.
V2f Aperture::sample_shape(const V2f& u) const {
  if (blades_ == 0) return sample_uniform_disk(u);
  const Ring ring = ring_of(u);
  const float along = ring.position * static_cast<float>(blades_);
  const float edge = std::min(std::floor(along), static_cast<float>(blades_ - 1));
  const SinCos corner = sincos_turns(first_corner_ + edge / static_cast<float>(blades_));
  const V2f from(corner.cos, corner.sin);
  const V2f to(corner.cos * step_cos_ - corner.sin * step_sin_, corner.sin * step_cos_ + corner.cos * step_sin_);
  return (from + (to - from) * (along - edge)) * ring.size;
}

// The front rim of the barrel is in front of the aperture: from a point off the axis it appears
// displaced towards the axis. Its radius is the aperture's, and so is its displacement in the
// corners of the image for an amount of 1.
V2f Aperture::barrel_center(const V2f& field) const { return field * -cats_eye_; }

V2f Aperture::sample(const V2f& u, const V2f& field) const {
  assert(u.x >= 0.0f && u.x <= 1.0f && u.y >= 0.0f && u.y <= 1.0f);
  V2f point = sample_shape(u);
  if (cats_eye_ > 0.0f) {
    uint32_t key = hash_combine(std::bit_cast<uint32_t>(u.x), std::bit_cast<uint32_t>(u.y));
    for (int i = 0; i < kMaxTries && is_hidden(point, field); ++i) point = next_point(key);
  }
  return {point.x * radius_ * width_over_height_, point.y * radius_};
}

V2f Aperture::next_point(uint32_t& key) const {
  key = hash_u32(key + 0x9e3779b9U);
  return sample_shape({to_unit_float(key), to_unit_float(hash_u32(key ^ 0x85157af5U))});
}

float Aperture::area_ratio(uint32_t key, const V2f& field) const {
  int points = 1;
  while (points < kMaxTries && is_hidden(next_point(key), field)) ++points;
  return static_cast<float>(points);
}

bool Aperture::contains(const V2f& point_m, const V2f& field) const {
  const V2f point(point_m.x / (radius_ * width_over_height_), point_m.y / radius_);
  constexpr float kRounding = 1e-5f;
  if (cats_eye_ > 0.0f && (point - barrel_center(field)).length() > 1.0f + kRounding) return false;
  if (blades_ == 0) return point.length() <= 1.0f + kRounding;
  for (int i = 0; i < blades_; ++i) { // the center of each edge
    const SinCos normal = sincos_turns(first_corner_ + (static_cast<float>(i) + 0.5f) / static_cast<float>(blades_));
    if (point.x * normal.cos + point.y * normal.sin > inner_radius_ + kRounding) return false;
  }
  return true;
}

} // namespace kindling
