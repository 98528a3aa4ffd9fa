// Renders the studio environment.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/builtin_environment.h"

#include "renderer/base/elementary_double.h"
#include "renderer/base/math.h"

#include <tbb/parallel_for.h>

#include <cstring>

namespace kindling {
namespace {

constexpr int kWidth = 256;
constexpr int kHeight = 128;

float smoothstep(float edge0, float edge1, float x) {
  const float t = std::clamp((x - edge0) / (edge1 - edge0), 0.0f, 1.0f);
  return t * t * (3.0f - 2.0f * t);
}

// Returns a round softbox around `axis`: 1 inside `inner_deg`, 0 outside `outer_deg`.
float softbox(const V3f& direction, const V3f& axis, float inner_deg, float outer_deg) {
  const float angle_deg = elementary::acos(std::clamp(direction.dot(axis.normalized()), -1.0f, 1.0f)) * 180.0f * kInvPi;
  return 1.0f - smoothstep(inner_deg, outer_deg, angle_deg);
}

float studio_radiance(const V3f& d) {
  const float sky = d.y >= 0.0f ? lerp(0.6f, 0.9f, d.y) : lerp(0.6f, 0.25f, smoothstep(0.0f, 0.35f, -d.y));
  return sky + 6.0f * softbox(d, V3f(0.7f, 0.9f, 0.6f), 16.0f, 24.0f) +
         2.0f * softbox(d, V3f(-0.9f, 0.5f, 0.2f), 18.0f, 30.0f);
}

} // namespace

std::string_view studio_name(Studio studio) {
  switch (studio) {
  case Studio::off: return "off";
  case Studio::on: return "on";
  case Studio::automatic: return "auto";
  }
  return "";
}

std::optional<Studio> studio_from_name(std::string_view name) {
  for (const Studio studio : {Studio::off, Studio::on, Studio::automatic})
    if (name == studio_name(studio)) return studio;
  return std::nullopt;
}

std::shared_ptr<const Environment> builtin_environment() {
  auto image = std::make_shared<Image>();
  image->width = kWidth;
  image->height = kHeight;
  image->channels = 3;
  image->type = PixelType::f32;
  image->pixels.resize(image->byte_count());
  tbb::parallel_for(0, kHeight, [&](int y) {
    std::byte* out = image->pixels.data() + static_cast<size_t>(y) * kWidth * 3 * sizeof(float);
    const float theta = (static_cast<float>(y) + 0.5f) / kHeight * kPi;
    for (int x = 0; x < kWidth; ++x) {
      const float phi = ((static_cast<float>(x) + 0.5f) / kWidth - 0.5f) * 2.0f * kPi;
      const float value = studio_radiance(V3f(elementary::sin(theta) * elementary::cos(phi), elementary::cos(theta),
                                              elementary::sin(theta) * elementary::sin(phi)));
      const float rgb[3] = {value, value, value};
      std::memcpy(out, rgb, sizeof rgb);
      out += sizeof rgb;
    }
  });
  return std::make_shared<Environment>(std::move(image), 0.0f, 1.0f);
}

} // namespace kindling
