// Resamples cube maps and spherical harmonics to equirectangular images.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/image_light_environment.h"

#include "renderer/base/elementary_double.h"

#include <tbb/parallel_for.h>

#include <cstring>

namespace kindling {
namespace {

constexpr int kMaxWidth = 8192;
constexpr int kCoefficientWidth = 64; // harmonics up to l = 2 vary slowly

// Viewing direction of a face, and directions of its image's columns and rows. OpenGL's
// (specification of OpenGL 4.6, table 8.19), mirrored left to right: "each saved image must be
// flipped about its vertical axis", which makes them views from within a right-handed world.
struct FaceAxes {
  V3f forward, right, down;
};
const FaceAxes kFaces[6] = {
    {{1, 0, 0}, {0, 0, 1}, {0, -1, 0}},   {{-1, 0, 0}, {0, 0, -1}, {0, -1, 0}}, {{0, 1, 0}, {-1, 0, 0}, {0, 0, 1}},
    {{0, -1, 0}, {-1, 0, 0}, {0, 0, -1}}, {{0, 0, 1}, {-1, 0, 0}, {0, -1, 0}},  {{0, 0, -1}, {1, 0, 0}, {0, -1, 0}},
};

struct CubePoint {
  size_t face = 0;
  float x = 0.0f; // in texels of the face
  float y = 0.0f;
};

CubePoint locate(const V3f& d, int size) {
  const V3f a(std::fabs(d.x), std::fabs(d.y), std::fabs(d.z));
  const size_t axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  const size_t face = 2 * axis + (d[static_cast<int>(axis)] < 0.0f ? 1 : 0);
  const FaceAxes& axes = kFaces[face];
  const float scale = 0.5f / d.dot(axes.forward);
  const auto n = static_cast<float>(size);
  return {face, (d.dot(axes.right) * scale + 0.5f) * n, (d.dot(axes.down) * scale + 0.5f) * n};
}

Rgb texel(const ImageLight& light, size_t face, int x, int y) {
  const Image& image = *light.faces[face];
  float rgb[3];
  const size_t index = static_cast<size_t>(y) * static_cast<size_t>(image.width) + static_cast<size_t>(x);
  std::memcpy(rgb, image.pixels.data() + index * sizeof rgb, sizeof rgb);
  return {rgb[0], rgb[1], rgb[2]};
}

// Returns the texel at (x, y) of a face, or that of the neighbor at this position if the face is
// extended flat beyond its edge.
Rgb texel_across_edges(const ImageLight& light, size_t face, int x, int y) {
  const int size = light.faces[0]->width;
  if (x >= 0 && y >= 0 && x < size && y < size) return texel(light, face, x, y);
  const FaceAxes& axes = kFaces[face];
  const float scale = 2.0f / static_cast<float>(size);
  const V3f d = axes.forward + axes.right * ((static_cast<float>(x) + 0.5f) * scale - 1.0f) +
                axes.down * ((static_cast<float>(y) + 0.5f) * scale - 1.0f);
  const CubePoint at = locate(d, size);
  const auto inside = [size](float c) { return std::clamp(static_cast<int>(c), 0, size - 1); };
  return texel(light, at.face, inside(at.x), inside(at.y));
}

Rgb cube_radiance(const ImageLight& light, const V3f& d) {
  const CubePoint at = locate(d, light.faces[0]->width);
  const float x = at.x - 0.5f;
  const float y = at.y - 0.5f;
  const int x0 = static_cast<int>(std::floor(x));
  const int y0 = static_cast<int>(std::floor(y));
  const float fx = x - static_cast<float>(x0);
  const float fy = y - static_cast<float>(y0);
  const auto row = [&](int yi) {
    return texel_across_edges(light, at.face, x0, yi) * (1.0f - fx) +
           texel_across_edges(light, at.face, x0 + 1, yi) * fx;
  };
  return row(y0) * (1.0f - fy) + row(y0 + 1) * fy;
}

// Ramamoorthi and Hanrahan, "An Efficient Representation for Irradiance Environment Maps" (2001):
// the irradiance coefficients are those of radiance times pi, 2 pi / 3 and pi / 4 for l = 0, 1, 2.
Rgb harmonic_radiance(const ImageLight& light, const V3f& d) {
  const float basis[9] = {0.282095f / kPi,
                          0.488603f * d.y / (2.0f * kPi / 3.0f),
                          0.488603f * d.z / (2.0f * kPi / 3.0f),
                          0.488603f * d.x / (2.0f * kPi / 3.0f),
                          1.092548f * d.x * d.y / (kPi / 4.0f),
                          1.092548f * d.y * d.z / (kPi / 4.0f),
                          0.315392f * (3.0f * d.z * d.z - 1.0f) / (kPi / 4.0f),
                          1.092548f * d.x * d.z / (kPi / 4.0f),
                          0.546274f * (d.x * d.x - d.y * d.y) / (kPi / 4.0f)};
  Rgb sum(0.0f);
  for (size_t i = 0; i < 9; ++i) sum += light.irradiance_coefficients[i] * basis[i];
  return {std::max(sum.x, 0.0f), std::max(sum.y, 0.0f), std::max(sum.z, 0.0f)};
}

} // namespace

Rgb image_light_radiance(const ImageLight& light, const V3f& wi) {
  Quatf back = light.rotation;
  back.v = -back.v;
  const V3f d = back.rotateVector(wi);
  return light.faces[0] ? cube_radiance(light, d) : harmonic_radiance(light, d);
}

std::shared_ptr<const Environment> image_light_environment(const ImageLight& light) {
  auto image = std::make_shared<Image>();
  image->width =
      light.faces[0] ? std::clamp(4 * light.faces[0]->width, kCoefficientWidth, kMaxWidth) : kCoefficientWidth;
  image->height = image->width / 2;
  image->channels = 3;
  image->type = PixelType::f32;
  image->pixels.resize(image->byte_count());
  const float step_u = 1.0f / static_cast<float>(image->width);
  const float step_v = 1.0f / static_cast<float>(image->height);
  tbb::parallel_for(0, image->height, [&](int y) {
    std::byte* out = image->pixels.data() + static_cast<size_t>(y) * static_cast<size_t>(image->width) * sizeof(Rgb);
    for (int x = 0; x < image->width; ++x) {
      Rgb sum(0.0f);
      for (const float dy : {0.25f, 0.75f}) {
        const float theta = (static_cast<float>(y) + dy) * step_v * kPi;
        for (const float dx : {0.25f, 0.75f}) {
          const float phi = ((static_cast<float>(x) + dx) * step_u - 0.5f) * 2.0f * kPi;
          sum += image_light_radiance(light, V3f(elementary::sin(theta) * elementary::cos(phi), elementary::cos(theta),
                                                 elementary::sin(theta) * elementary::sin(phi)));
        }
      }
      sum *= 0.25f;
      std::memcpy(out + static_cast<size_t>(x) * sizeof sum, &sum, sizeof sum);
    }
  });
  return std::make_shared<Environment>(std::move(image), 0.0f, light.intensity);
}

} // namespace kindling
