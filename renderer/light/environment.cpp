// Prepares an Environment from a picture, and samples it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/environment.h"

#include "renderer/sampling/warp.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_reduce.h>

#include <cstring>

namespace kindling {

namespace {

// Linear texel of a picture, as it is used: grey replicated, no alpha, nothing negative or non-finite.
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
    return static_cast<float>(s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4));
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

// Root mean square over the texel in the middle of the bilinear interpolation of its 3 x 3 neighbourhood: with one
// constant density per texel this is the one that minimizes the variance. With hat functions a_i over s in [-1/2, 1/2]
// the mean square is the sum of V_ij V_kl A_ik A_jl, where A_ik is the integral of a_i a_k.
float rms_of_interpolation(const float v[3][3]) {
  constexpr float kDiagonal = 1.0f / 24.0f;
  constexpr float kCentre = 14.0f / 24.0f;
  constexpr float kBeside = 2.0f / 24.0f;
  const auto apply = [](const float a[3], float out[3]) {
    out[0] = kDiagonal * a[0] + kBeside * a[1];
    out[1] = kBeside * (a[0] + a[2]) + kCentre * a[1];
    out[2] = kBeside * a[1] + kDiagonal * a[2];
  };
  float columns[3][3];
  for (int j = 0; j < 3; ++j) {
    const float column[3] = {v[0][j], v[1][j], v[2][j]};
    apply(column, columns[j]);
  }
  float sum = 0.0f;
  for (int i = 0; i < 3; ++i) {
    const float row[3] = {columns[0][i], columns[1][i], columns[2][i]};
    float mixed[3];
    apply(row, mixed);
    sum += mixed[0] * v[i][0] + mixed[1] * v[i][1] + mixed[2] * v[i][2];
  }
  return std::sqrt(std::max(sum, 0.0f));
}

// Integral over theta of sin(theta) times the hat function of row y of `height` (clamped at the poles).
double row_integral(int y, int height) {
  const double step = std::numbers::pi / height;
  // From the row's centre at angle t0 to the next row's centre, or to the pole if there is none.
  const auto half_hat = [step](double t0, bool last) {
    return last ? std::cos(t0) + 1.0 : std::cos(t0) - (std::sin(t0 + step) - std::sin(t0)) / step;
  };
  const double centre = (y + 0.5) * step;
  return half_hat(centre, y == height - 1) + half_hat(std::numbers::pi - centre, y == 0);
}

} // namespace

Environment::Environment(const Rgb& radiance)
    : pdf_scale_(kindling::is_black(radiance) ? 0.0f : 0.25f * kInvPi), constant_(radiance),
      total_radiance_(radiance * (4.0f * kPi)) {}

Environment::Environment(std::shared_ptr<const Image> picture, float rotation_rad, float intensity) {
  if (!picture || picture->width < 1 || picture->height < 1 || picture->channels < 1 || !(intensity > 0.0f)) return;
  const double turns = static_cast<double>(rotation_rad) / (2.0 * std::numbers::pi);
  rotation_turns_ = static_cast<float>(turns - std::floor(turns));
  if (!(rotation_turns_ < 1.0f)) rotation_turns_ = 0.0f;
  if (!store_texels(*picture, intensity)) return;
  build_distribution();
}

bool Environment::store_texels(const Image& image, float intensity) {
  const TexelReader texel(image);
  const float peak = brightest(image, texel);
  if (!(peak > 0.0f)) return false;
  width_ = image.width;
  height_ = image.height;
  texels_.resize((static_cast<size_t>(width_) + 2) * (static_cast<size_t>(height_) + 2));

  // The brightest value lands in [2^14, 2^15): the largest half is 65504.
  int exponent = 0;
  (void)std::frexp(peak, &exponent);
  exponent = std::max(exponent, -100); // 2^(15 - exponent) must be finite
  const float to_stored = std::ldexp(1.0f, 15 - exponent);
  scale_ = std::ldexp(intensity, exponent - 15);

  std::vector<V3d> row_sums(static_cast<size_t>(height_), V3d(0.0));
  tbb::parallel_for(tbb::blocked_range<int>(0, height_, 16), [&](const tbb::blocked_range<int>& rows) {
    for (int y = rows.begin(); y < rows.end(); ++y) {
      V3d sum(0.0);
      for (int x = 0; x < width_; ++x) {
        const Rgb c = texel(x, y) * to_stored;
        HalfTexel& t = texels_[texel_index(x, y)];
        t = {float_to_half(c.x), float_to_half(c.y), float_to_half(c.z), 0};
        sum += V3d(half_to_float(t.r), half_to_float(t.g), half_to_float(t.b));
      }
      row_sums[static_cast<size_t>(y)] = sum;
    }
  });
  fill_border();
  V3d total(0.0);
  for (int y = 0; y < height_; ++y) total += row_sums[static_cast<size_t>(y)] * row_integral(y, height_);
  total *= 2.0 * std::numbers::pi / width_ * static_cast<double>(scale_);
  total_radiance_ = Rgb(static_cast<float>(total.x), static_cast<float>(total.y), static_cast<float>(total.z));
  return true;
}

void Environment::fill_border() {
  const size_t stride = static_cast<size_t>(width_) + 2;
  for (int y = 0; y < height_; ++y) {
    texels_[texel_index(-1, y)] = texels_[texel_index(width_ - 1, y)];
    texels_[texel_index(width_, y)] = texels_[texel_index(0, y)];
  }
  std::copy_n(&texels_[texel_index(-1, 0)], stride, &texels_[texel_index(-1, -1)]);
  std::copy_n(&texels_[texel_index(-1, height_ - 1)], stride, &texels_[texel_index(-1, height_)]);
}

void Environment::build_distribution() {
  const auto columns = static_cast<size_t>(width_);
  const auto rows = static_cast<size_t>(height_);
  polar_edges_.resize(rows + 1);
  for (size_t y = 0; y <= rows; ++y) {
    const double s = std::sin(0.5 * std::numbers::pi * static_cast<double>(y) / height_);
    polar_edges_[y] = static_cast<float>(2.0 * s * s);
  }
  std::vector<double> solid_angles(rows); // of one texel
  to_solid_angle_.resize(rows);
  const double band = std::numbers::pi / height_;
  for (size_t y = 0; y < rows; ++y) {
    solid_angles[y] =
        2.0 * std::numbers::pi / width_ * 2.0 * std::sin((static_cast<double>(y) + 0.5) * band) * std::sin(0.5 * band);
    to_solid_angle_[y] = static_cast<float>(1.0 / (solid_angles[y] * width_ * height_));
  }

  const auto stored_luminance = [&](int x, int y) {
    const HalfTexel& t = texels_[texel_index(x, y)];
    return luminance({half_to_float(t.r), half_to_float(t.g), half_to_float(t.b)});
  };
  std::vector<float> weights(columns * rows);
  tbb::parallel_for(tbb::blocked_range<int>(0, height_, 16), [&](const tbb::blocked_range<int>& range) {
    for (int y = range.begin(); y < range.end(); ++y) {
      float v[3][3] = {};
      for (int i = 0; i < 3; ++i) {
        v[i][1] = stored_luminance(-1, y + i - 1);
        v[i][2] = stored_luminance(0, y + i - 1);
      }
      for (int x = 0; x < width_; ++x) {
        bool any = false;
        for (int i = 0; i < 3; ++i) {
          v[i][0] = v[i][1];
          v[i][1] = v[i][2];
          v[i][2] = stored_luminance(x + 1, y + i - 1);
          any = any || v[i][0] > 0.0f || v[i][1] > 0.0f || v[i][2] > 0.0f;
        }
        const double weight = static_cast<double>(rms_of_interpolation(v)) * solid_angles[static_cast<size_t>(y)];
        weights[static_cast<size_t>(y) * columns + static_cast<size_t>(x)] =
            any ? std::max(static_cast<float>(weight), std::numeric_limits<float>::min()) : 0.0f;
      }
    }
  });
  distribution_ = Distribution2D(weights, static_cast<uint32_t>(width_), static_cast<uint32_t>(height_));
  store_densities();
}

// The density of a texel is kept beside its colour, so that a look-up finds both in the same cache line.
void Environment::store_densities() {
  const auto density = [&](int x, int y) {
    return distribution_.probability(static_cast<uint32_t>(x), static_cast<uint32_t>(y)) * static_cast<float>(width_) *
           static_cast<float>(height_) * to_solid_angle_[static_cast<size_t>(y)];
  };
  float greatest = 0.0f;
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) greatest = std::max(greatest, density(x, y));
  }
  int exponent = 0;
  (void)std::frexp(greatest, &exponent);
  pdf_scale_ = std::ldexp(1.0f, exponent - 15);
  tbb::parallel_for(tbb::blocked_range<int>(0, height_, 16), [&](const tbb::blocked_range<int>& range) {
    constexpr float kSmallestHalf = 0x1p-24f;
    for (int y = range.begin(); y < range.end(); ++y) {
      for (int x = 0; x < width_; ++x) {
        const float d = density(x, y);
        texels_[texel_index(x, y)].density = d > 0.0f ? float_to_half(std::max(d / pdf_scale_, kSmallestHalf)) : 0;
      }
    }
  });
  fill_border();
}

LightSample Environment::sample(const V2f& u) const {
  LightSample result;
  result.distance = kInfinity;
  if (is_black()) {
    result.wi = V3f(0.0f, 1.0f, 0.0f);
    return result;
  }
  if (width_ == 0) {
    result.wi = sample_uniform_sphere(u);
    result.radiance = constant_;
    result.pdf = pdf_scale_;
    return result;
  }
  const Distribution2D::Sample chosen = distribution_.sample(u);

  // Uniform by solid angle in the texel. 1 - |cos(theta)| is measured from the nearer pole, where cos(theta) has no
  // digits.
  const bool lower = 2 * static_cast<int>(chosen.row) >= height_;
  const auto rows = static_cast<size_t>(height_);
  const size_t y = chosen.row;
  const float upper_edge = polar_edges_[lower ? rows - y : y];
  const float lower_edge = polar_edges_[lower ? rows - y - 1 : y + 1];
  const float fraction = chosen.uv.y * static_cast<float>(height_) - static_cast<float>(y);
  const float polar = lerp(upper_edge, lower_edge, std::clamp(fraction, 0.0f, 1.0f));
  const float sin_theta = safe_sqrt(polar * (2.0f - polar));
  const float cos_theta = lower ? polar - 1.0f : 1.0f - polar;

  const SinCos phi = sincos_turns(chosen.uv.x - 0.5f - rotation_turns_);
  result.wi = V3f(sin_theta * phi.cos, cos_theta, sin_theta * phi.sin);
  result.radiance = eval_uv(chosen.uv.x, acos_half_turns(cos_theta)).radiance;
  // Of the texel that was drawn: rounding may put the direction just across its border.
  result.pdf = chosen.pdf * to_solid_angle_[y];
  return result;
}

size_t Environment::memory_bytes() const {
  return sizeof(*this) + texels_.size() * sizeof(HalfTexel) +
         (polar_edges_.size() + to_solid_angle_.size()) * sizeof(float) + distribution_.memory_bytes();
}

} // namespace kindling
