// Prepares an Environment from an image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/environment.h"

#include "renderer/base/elementary_double.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <cassert>
#include <cstring>

namespace kindling {

namespace {

// Reads linear texels: gray is replicated, alpha dropped, negative and non-finite values are 0.
class TexelReader {
 public:
  explicit TexelReader(const Image& image) : image_(image) {
    if (image.type == PixelType::u8 || image.type == PixelType::u16) {
      const size_t count = image.type == PixelType::u8 ? 256 : 65536;
      linear_.resize(count);
      for (size_t i = 0; i < count; ++i)
        linear_[i] = decode_srgb(static_cast<double>(i) / static_cast<double>(count - 1));
    }
  }

  [[nodiscard]] Rgb operator()(int x, int y) const {
    const size_t pixel = static_cast<size_t>(y) * static_cast<size_t>(image_.width) + static_cast<size_t>(x);
    const size_t first = pixel * static_cast<size_t>(image_.channels);
    if (image_.channels < 3) return Rgb(channel(first));
    return {channel(first), channel(first + 1), channel(first + 2)};
  }

 private:
  // IEC 61966-2-1.
  static float decode_srgb(double s) {
    return static_cast<float>(s <= 0.04045 ? s / 12.92 : elementary::pow((s + 0.055) / 1.055, 2.4));
  }

  template <typename T>
  [[nodiscard]] T stored(size_t index) const {
    T value;
    std::memcpy(&value, image_.pixels.data() + index * sizeof(T), sizeof(T));
    return value;
  }

  [[nodiscard]] float channel(size_t index) const {
    float value = 0.0f;
    switch (image_.type) {
    case PixelType::u8: return linear_[stored<uint8_t>(index)];
    case PixelType::u16: return linear_[stored<uint16_t>(index)];
    case PixelType::f16: value = half_to_float(stored<uint16_t>(index)); break;
    case PixelType::f32: value = stored<float>(index); break;
    }
    return std::isfinite(value) && value > 0.0f ? value : 0.0f;
  }

  const Image& image_;
  std::vector<float> linear_;
};

float brightest(const Image& image, const TexelReader& texel) {
  return tbb::parallel_reduce(
      tbb::blocked_range<int>(0, image.height, 16), 0.0f,
      [&](const tbb::blocked_range<int>& rows, float found) {
        for (int y = rows.begin(); y < rows.end(); ++y) {
          for (int x = 0; x < image.width; ++x) found = std::max(found, max_component(texel(x, y)));
        }
        return found;
      },
      [](float a, float b) { return std::max(a, b); });
}

// Returns the integral over theta of sin(theta) times the hat function of row y of `height`
// (clamped at the poles).
double row_integral(int y, int height) {
  const double step = std::numbers::pi / height;
  // From the row's center at angle t0 to the next row's center, or to the pole after the last row.
  const auto half_hat = [step](double t0, bool last) {
    return last ? elementary::cos(t0) + 1.0
                : elementary::cos(t0) - (elementary::sin(t0 + step) - elementary::sin(t0)) / step;
  };
  const double center = (y + 0.5) * step;
  return half_hat(center, y == height - 1) + half_hat(std::numbers::pi - center, y == 0);
}

} // namespace

Environment::Environment(const Rgb& radiance) {
  constant_pdf = kindling::is_black(radiance) ? 0.0f : 0.25f * kInvPi;
  constant = radiance;
  total_radiance = radiance * (4.0f * kPi);
}

Environment::Environment(const std::shared_ptr<const Image>& image, float rotation_rad, float intensity) {
  if (!image || image->width < 1 || image->height < 1 || image->channels < 1 || !(intensity > 0.0f)) return;
  const double turns = static_cast<double>(rotation_rad) / (2.0 * std::numbers::pi);
  rotation_turns = static_cast<float>(turns - std::floor(turns));
  if (!(rotation_turns < 1.0f)) rotation_turns = 0.0f;
  texels = arrays_.keep(store_texels(*image, intensity));
  if (texels.empty()) return;
  build_distribution();
  build_levels();
}

std::vector<Fp16Texel> Environment::store_texels(const Image& image, float intensity) {
  const TexelReader texel(image);
  const float peak = brightest(image, texel);
  if (!(peak > 0.0f)) return {};
  width = image.width;
  height = image.height;
  std::vector<Fp16Texel> stored((static_cast<size_t>(width) + 2) * (static_cast<size_t>(height) + 2));

  // The brightest value is scaled to [2^14, 2^15): the largest half is 65504.
  int exponent = 0;
  (void)std::frexp(peak, &exponent);
  exponent = std::max(exponent, -100); // 2^(15 - exponent) must be finite
  const float to_stored = std::ldexp(1.0f, 15 - exponent);
  scale = std::ldexp(intensity, exponent - 15);

  std::vector<V3d> row_sums(static_cast<size_t>(height), V3d(0.0));
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      V3d sum(0.0);
      for (int x = 0; x < width; ++x) {
        const Rgb c = texel(x, y) * to_stored;
        Fp16Texel& t = stored[texel_index(x, y)];
        t = {float_to_half(c.x), float_to_half(c.y), float_to_half(c.z), 0};
        const Rgb rounded(half_to_float(t.r), half_to_float(t.g), half_to_float(t.b));
        // Positive wherever the color is.
        t.weight = kindling::is_black(rounded) ? 0 : std::max<uint16_t>(1, float_to_half(luminance(rounded)));
        sum += V3d(rounded);
      }
      row_sums[static_cast<size_t>(y)] = sum;
    }
  });
  V3d total(0.0);
  for (int y = 0; y < height; ++y) total += row_sums[static_cast<size_t>(y)] * row_integral(y, height);
  compensate_for_mis(luminance(V3f(total)) / (2.0f * static_cast<float>(width)), stored); // sin(theta) integrates to 2
  fill_border(stored);
  total *= 2.0 * std::numbers::pi / width * static_cast<double>(scale);
  total_radiance = Rgb(static_cast<float>(total.x), static_cast<float>(total.y), static_cast<float>(total.z));
  return stored;
}

// Subtracts most of the mean from the density, because BSDF sampling finds uniform light as well
// (Karlik et al., "MIS Compensation: Optimizing Sampling Techniques in Multiple Importance
// Sampling", SIGGRAPH Asia 2019, section 5.1). The paper subtracts the whole mean, which is optimal
// for the balance heuristic without occlusion; the power heuristic and occlusion favor a little
// less. No weight becomes zero.
void Environment::compensate_for_mis(float mean_weight, std::vector<Fp16Texel>& stored) {
  constexpr float kMeanFraction = 0.7f;
  constexpr float kMin = 0.02f; // of the texel's own weight
  struct RowSums {
    double all = 0.0, left = 0.0;
  };
  std::vector<RowSums> row_sums(static_cast<size_t>(height));
  tbb::parallel_for(tbb::blocked_range<int>(0, height, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      RowSums sums;
      for (int x = 0; x < width; ++x) {
        Fp16Texel& t = stored[texel_index(x, y)];
        if (t.weight == 0) continue;
        const float weight = half_to_float(t.weight);
        const float left = std::max(weight - kMeanFraction * mean_weight, kMin * weight);
        t.weight = std::max<uint16_t>(1, float_to_half(left));
        sums.all += static_cast<double>(weight);
        sums.left += static_cast<double>(left);
      }
      row_sums[static_cast<size_t>(y)] = sums;
    }
  });
  double all = 0.0, left_of_all = 0.0;
  for (int y = 0; y < height; ++y) {
    all += row_sums[static_cast<size_t>(y)].all * row_integral(y, height);
    left_of_all += row_sums[static_cast<size_t>(y)].left * row_integral(y, height);
  }
  sampled_fraction_ = static_cast<float>(std::min(left_of_all / all, 1.0));
}

void Environment::fill_border(std::vector<Fp16Texel>& stored) const {
  const size_t stride = static_cast<size_t>(width) + 2;
  for (int y = 0; y < height; ++y) {
    stored[texel_index(-1, y)] = stored[texel_index(width - 1, y)];
    stored[texel_index(width, y)] = stored[texel_index(0, y)];
  }
  std::copy_n(&stored[texel_index(-1, 0)], stride, &stored[texel_index(-1, -1)]);
  std::copy_n(&stored[texel_index(-1, height - 1)], stride, &stored[texel_index(-1, height)]);
}

void Environment::build_distribution() {
  const auto columns = static_cast<size_t>(width);
  const auto rows = static_cast<size_t>(height) + 1;
  // Cell rows run from texel center to texel center, so the first and the last are half as high and
  // end at the poles.
  const auto theta_of_edge = [this](size_t row) {
    return std::clamp((static_cast<double>(row) - 0.5) / height, 0.0, 1.0) * std::numbers::pi;
  };
  std::vector<double> cos_bands(rows); // cos(theta) at the top minus that at the bottom: solid angle over 2 pi
  for (size_t y = 0; y < rows; ++y)
    cos_bands[y] = elementary::cos(theta_of_edge(y)) - elementary::cos(theta_of_edge(y + 1));

  std::vector<float> weights(columns * rows);
  std::vector<double> row_sums(rows);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, rows, 16), [&](const tbb::blocked_range<size_t>& range) {
    for (size_t y = range.begin(); y < range.end(); ++y) {
      // Border texels repeat the image's, so the rows at the poles need no special case.
      const Fp16Texel* upper = &texels[texel_index(0, static_cast<int>(y) - 1)];
      const Fp16Texel* lower = &texels[texel_index(0, static_cast<int>(y))];
      double sum = 0.0;
      for (size_t x = 0; x < columns; ++x) {
        const float mean = 0.25f * (half_to_float(upper[x].weight) + half_to_float(upper[x + 1].weight) +
                                    half_to_float(lower[x].weight) + half_to_float(lower[x + 1].weight));
        const double weight = static_cast<double>(mean) * cos_bands[y];
        weights[y * columns + x] = static_cast<float>(weight);
        sum += weight;
      }
      row_sums[y] = sum;
    }
  });
  double total = 0.0;
  for (const double sum : row_sums) total += sum;
  stored_distribution_ = Distribution2D(weights, static_cast<uint32_t>(columns), static_cast<uint32_t>(rows));
  distribution = static_cast<const Distribution2DView&>(stored_distribution_);
  // The density in the image's unit square is weight * band / total * (cells per unit square); over
  // solid angle it is divided by 2 pi^2 sin(theta).
  std::vector<float> factors(rows);
  for (size_t y = 0; y < rows; ++y) {
    const double cell_height = (theta_of_edge(y + 1) - theta_of_edge(y)) / std::numbers::pi;
    factors[y] = static_cast<float>(cos_bands[y] / total * static_cast<double>(columns) / cell_height /
                                    (2.0 * std::numbers::pi * std::numbers::pi));
  }
  row_factors = arrays_.keep(std::move(factors));
}

void Environment::build_levels() {
  int level_width = EnvironmentLevels::kMaxWidth;
  while (2 * level_width > width) level_width /= 2;
  if (level_width < EnvironmentLevels::kMinWidth) return;
  levels.texels = arrays_.keep(make_environment_levels(texels, width, height, level_width));
  levels.width = level_width;
}

} // namespace kindling
