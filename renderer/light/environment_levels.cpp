// Averages the texels of an environment, level by level.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/environment_levels.h"

#include "renderer/base/elementary_double.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cmath>
#include <numbers>

namespace kindling {

namespace {

// An image without a border, by row.
struct Texels {
  int width, height;
  std::vector<V3f> radiance = std::vector<V3f>(static_cast<size_t>(width) * static_cast<size_t>(height));

  [[nodiscard]] V3f& at(int x, int y) {
    return radiance[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
  [[nodiscard]] const V3f& at(int x, int y) const {
    return radiance[static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x)];
  }
};

// Calls f(i, a, b) for the parts [a, b] of the texels i that part `number` of `count` equal parts
// of a row (or column) of `texels` texels covers; a and b in [0, 1], of the row.
template <typename F>
void for_each_covered(int number, int count, int texels, F&& f) {
  const double begin = static_cast<double>(number) / count, end = static_cast<double>(number + 1) / count;
  const int last = std::min(static_cast<int>(std::ceil(end * texels)), texels);
  for (int i = static_cast<int>(begin * texels); i < last; ++i) {
    const double a = std::max(begin, static_cast<double>(i) / texels);
    const double b = std::min(end, static_cast<double>(i + 1) / texels);
    if (b > a) f(i, a, b);
  }
}

// Returns the means of an image over the texels of another one, by solid angle.
template <typename Read>
Texels averaged(int from_width, int from_height, int width, const Read& read) {
  Texels to{width, width / 2};
  tbb::parallel_for(tbb::blocked_range<int>(0, to.height), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y)
      for (int x = 0; x < width; ++x) {
        V3d sum(0.0);
        double total = 0.0;
        for_each_covered(y, to.height, from_height, [&](int row, double top, double bottom) {
          const double height = elementary::cos(top * std::numbers::pi) - elementary::cos(bottom * std::numbers::pi);
          for_each_covered(x, width, from_width, [&](int column, double left, double right) {
            sum += V3d(read(column, row)) * (height * (right - left));
            total += height * (right - left);
          });
        });
        to.at(x, y) = V3f(sum / total);
      }
  });
  return to;
}

void store(const Texels& level, std::vector<Fp16Texel>& stored) {
  for (int y = -1; y <= level.height; ++y)
    for (int x = -1; x <= level.width; ++x) {
      const V3f& c = level.at((x + level.width) % level.width, std::clamp(y, 0, level.height - 1));
      stored.push_back({float_to_half(c.x), float_to_half(c.y), float_to_half(c.z), 0});
    }
}

} // namespace

std::vector<Fp16Texel> make_environment_levels(std::span<const Fp16Texel> texels, int width, int height,
                                               int level_width) {
  const size_t stride = static_cast<size_t>(width) + 2;
  Texels level = averaged(width, height, level_width, [&](int x, int y) {
    const Fp16Texel& t = texels[static_cast<size_t>(y + 1) * stride + static_cast<size_t>(x + 1)];
    return V3f(half_to_float(t.r), half_to_float(t.g), half_to_float(t.b));
  });
  std::vector<Fp16Texel> stored;
  store(level, stored);
  for (int w = level_width / 2; w >= EnvironmentLevels::kMinWidth; w /= 2) {
    level = averaged(level.width, level.height, w, [&](int x, int y) { return level.at(x, y); });
    store(level, stored);
  }
  return stored;
}

} // namespace kindling
