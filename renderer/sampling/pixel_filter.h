// Importance-sampled pixel filters: a sample moves to where the filter wants it, and belongs to one pixel alone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

enum class FilterKind : uint8_t { blackman_harris, gaussian, box, mitchell };

// "blackman-harris", "gaussian", "box", "mitchell".
[[nodiscard]] std::string_view filter_name(FilterKind kind);
// Empty for any other name.
[[nodiscard]] std::optional<FilterKind> filter_from_name(std::string_view name);
// Full width in pixels: Blackman-Harris and Gaussian 1.5, box 1, Mitchell 4.
[[nodiscard]] float default_filter_width(FilterKind kind);
// The filter along one axis, unnormalized: 1 at the center for all but Mitchell; 0 outside of +-width / 2. x in pixels.
//   blackman_harris  the four-term window (Harris 1978) over the width
//   gaussian         standard deviation width / 6, cut at three of them
//   mitchell         B = C = 1/3 (Mitchell and Netravali 1988), its four unit intervals stretched to the width
[[nodiscard]] double filter_value(FilterKind kind, double width, double x);

struct PixelFilterOptions {
  FilterKind kind = FilterKind::blackman_harris;
  float width = 0.0f; // full width in pixels; 0: the default of the kind
};

// Separable: density proportional to |f(x) f(y)|, where f is interpolated linearly between 129 values on each side. A
// pixel is the plain mean of weight times radiance over its samples: the mean of the weights is 1. They are exactly 1
// for filters without negative lobes; for Mitchell they are +-c with c = (integral |f| / integral f)^2, about 1.145.
class PixelFilter {
 public:
  struct Sample {
    V2f offset{0.0f}; // from the pixel's center, in pixels, each within +-width / 2
    float weight = 1.0f;
  };

  explicit PixelFilter(const PixelFilterOptions& options = {});

  // u in [0, 1)^2. Monotone in each coordinate: stratification is kept.
  [[nodiscard]] Sample sample(const V2f& u) const;
  // Density of the offsets, per square pixel; 0 outside.
  [[nodiscard]] float pdf(const V2f& offset) const { return pdf_axis(offset.x) * pdf_axis(offset.y); }

  [[nodiscard]] FilterKind kind() const { return kind_; }
  [[nodiscard]] float width() const { return 2.0f * radius_; }

 private:
  static constexpr uint32_t kCells = 128;
  static constexpr uint32_t kGuideSize = 256;

  struct AxisSample {
    float offset;
    float weight;
  };
  [[nodiscard]] AxisSample sample_axis(float u) const;
  [[nodiscard]] float pdf_axis(float x) const;

  FilterKind kind_;
  float radius_;
  float negative_from_ = kInfinity;       // |x| beyond which the filter is negative
  float axis_weight_ = 1.0f;              // integral |f| / integral f
  std::array<float, kCells + 1> density_; // of |x| at i * radius / kCells, per pixel; integrates to 1
  std::array<float, kCells + 1> cdf_;     // of |x|, its exact integral
  std::array<uint8_t, kGuideSize> guide_; // cell in which cdf_ passes i / kGuideSize: where the search starts
};

} // namespace kindling
