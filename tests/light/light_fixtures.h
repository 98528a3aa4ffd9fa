// Images and estimators shared by the tests of lights.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/image/image.h"
#include "renderer/light/light_set.h"
#include "tests/sampling/estimate.h"
#include "tests/sampling/random.h"

#include <cmath>
#include <cstring>
#include <functional>
#include <memory>

namespace kindling::test {

inline V3f rotate_y(const V3f& d, float r) {
  return {d.x * std::cos(r) + d.z * std::sin(r), d.y, d.z * std::cos(r) - d.x * std::sin(r)};
}

// Returns an image of floats; `value` gives the texel at (x, y).
inline std::shared_ptr<const Image> float_image(int width, int height, const std::function<Rgb(int, int)>& value) {
  auto image = std::make_shared<Image>();
  image->width = width;
  image->height = height;
  image->channels = 3;
  image->type = PixelType::f32;
  image->pixels.resize(image->byte_count());
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const Rgb c = value(x, y);
      const size_t pixel = static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
      std::memcpy(image->pixels.data() + pixel * 12, c.getValue(), 12);
    }
  }
  return image;
}

// Deliberately uneven: noise over three decades, a black quarter, black poles and one very bright
// texel.
inline std::shared_ptr<const Image> uneven_image(int width, int height) {
  Random random(7);
  return float_image(width, height, [&](int x, int y) {
    const float level = std::pow(10.0f, -1.5f + 3.0f * random.next_1d());
    const Rgb c(level, level * random.next_1d(), level * 0.5f);
    if (x == width / 3 && y == height / 3) return Rgb(4000.0f, 3000.0f, 2000.0f);
    const bool black = (x > width / 2 && y > height / 2) || y == 0 || y == height - 1;
    return black ? Rgb(0.0f) : c;
  });
}

// Estimates the irradiance (luminance) at a point with this normal by sampling the lights.
inline Estimate sampled_irradiance(const LightSet& lights, const V3f& point, const V3f& normal, size_t samples,
                                   uint32_t seed) {
  Random random(seed);
  Estimate estimate;
  for (size_t i = 0; i < samples; ++i) {
    const float u_light = random.next_1d();
    const auto s = lights.sample(point, normal, u_light, random.next_2d());
    const float cosine = s ? std::max(s->wi.dot(normal), 0.0f) : 0.0f;
    estimate.add(cosine > 0.0f ? static_cast<double>(luminance(s->radiance) * cosine / s->pdf) : 0.0);
  }
  return estimate;
}

// Adds two triangles: corner, corner + a, corner + a + b, corner + b. They emit to the side of a x
// b.
inline void add_rectangle(LightSetInput& input, const V3f& corner, const V3f& a, const V3f& b, uint32_t emission) {
  input.triangles.push_back({corner, corner + a, corner + a + b, emission});
  input.triangles.push_back({corner, corner + a + b, corner + b, emission});
}

} // namespace kindling::test
