// Samples animation channels: STEP, LINEAR and CUBICSPLINE (glTF 2.0 specification, appendix C).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/scene/animation.h"

#include "renderer/base/elementary.h"

#include <cassert>

namespace kindling {
namespace {

// The three vectors stored for each CUBICSPLINE key.
enum SplineEntry : size_t { kInTangent = 0, kValue = 1, kOutTangent = 2 };

// Returns the components of one key; `entry` selects tangents of splines.
std::span<const float> key_values(const AnimationChannel& channel, size_t key, SplineEntry entry = kValue) {
  const auto components = static_cast<size_t>(channel.components);
  const bool spline = channel.interpolation == Interpolation::cubic_spline;
  const size_t index = spline ? 3 * key + entry : key;
  assert((index + 1) * components <= channel.values.size());
  return std::span(channel.values).subspan(index * components, components);
}

void normalize_quaternion(std::span<float> q) {
  const float length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (length > 0.0f && std::isfinite(length)) {
    for (float& c : q) c /= length;
  } else {
    q[0] = q[1] = q[2] = 0.0f;
    q[3] = 1.0f;
  }
}

// Spherical interpolation along the shorter arc; linear where the arc is too short to divide by its
// sine.
void slerp_shortest(std::span<const float> a, std::span<const float> b, float t, std::span<float> out) {
  float qa[4] = {a[0], a[1], a[2], a[3]};
  float qb[4] = {b[0], b[1], b[2], b[3]};
  normalize_quaternion(qa);
  normalize_quaternion(qb);
  const float dot = qa[0] * qb[0] + qa[1] * qb[1] + qa[2] * qb[2] + qa[3] * qb[3];
  const float sign = dot < 0.0f ? -1.0f : 1.0f;
  const float angle = elementary::acos(std::min(std::abs(dot), 1.0f));
  float weight_a = 1.0f - t;
  float weight_b = t;
  if (angle > 1e-3f) {
    const float inverse_sine = 1.0f / elementary::sin(angle);
    weight_a = elementary::sin((1.0f - t) * angle) * inverse_sine;
    weight_b = elementary::sin(t * angle) * inverse_sine;
  }
  for (size_t c = 0; c < 4; ++c) out[c] = weight_a * qa[c] + sign * weight_b * qb[c];
}

// Hermite spline between keys k and k + 1, `duration_s` apart, at t in [0, 1].
void hermite(const AnimationChannel& channel, size_t k, float t, float duration_s, std::span<float> out) {
  const auto p0 = key_values(channel, k);
  const auto m0 = key_values(channel, k, kOutTangent);
  const auto m1 = key_values(channel, k + 1, kInTangent);
  const auto p1 = key_values(channel, k + 1);
  const float t2 = t * t;
  const float t3 = t2 * t;
  for (size_t c = 0; c < out.size(); ++c) {
    out[c] = (2.0f * t3 - 3.0f * t2 + 1.0f) * p0[c] + duration_s * (t3 - 2.0f * t2 + t) * m0[c] +
             (-2.0f * t3 + 3.0f * t2) * p1[c] + duration_s * (t3 - t2) * m1[c];
  }
}

} // namespace

bool is_rotation(const AnimationChannel& channel) {
  return channel.property == AnimatedProperty::rotation ||
         (channel.property == AnimatedProperty::member && channel.member.quaternion);
}

void sample_channel(const AnimationChannel& channel, double time_s, std::span<float> out) {
  const std::vector<float>& times = channel.times_s;
  assert(!times.empty() && out.size() == static_cast<size_t>(channel.components));

  // Key k is the last at or before the time; times outside of the keys are not interpolated.
  const auto after = std::upper_bound(times.begin(), times.end(), time_s);
  const size_t k = after == times.begin() ? 0 : static_cast<size_t>(after - times.begin()) - 1;
  const bool between = after != times.begin() && after != times.end();
  const bool rotation = is_rotation(channel);

  if (!between || channel.interpolation == Interpolation::step) {
    const auto value = key_values(channel, k);
    std::copy(value.begin(), value.end(), out.begin());
  } else {
    const double start_s = times[k];
    const double duration_s = static_cast<double>(times[k + 1]) - start_s;
    const auto t = static_cast<float>((time_s - start_s) / duration_s);
    if (channel.interpolation == Interpolation::cubic_spline) {
      hermite(channel, k, t, static_cast<float>(duration_s), out);
    } else if (rotation) {
      slerp_shortest(key_values(channel, k), key_values(channel, k + 1), t, out);
    } else {
      const auto a = key_values(channel, k);
      const auto b = key_values(channel, k + 1);
      for (size_t c = 0; c < out.size(); ++c) out[c] = lerp(a[c], b[c], t);
    }
  }
  if (rotation) normalize_quaternion(out);
}

} // namespace kindling
