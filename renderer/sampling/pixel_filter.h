// Importance-sampled pixel filters: samples are placed by the filter and belong to one pixel.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/lanes.h"
#include "renderer/base/math.h"

#include <array>
#include <cstdint>
#include <optional>
#include <string_view>

namespace kindling {

enum class FilterKind : uint8_t { blackman_harris, gaussian, box, mitchell };

// Returns "blackman-harris", "gaussian", "box" or "mitchell".
[[nodiscard]] std::string_view filter_name(FilterKind kind);
// Returns the filter of a name; empty for an unknown name.
[[nodiscard]] std::optional<FilterKind> filter_from_name(std::string_view name);
// Returns the full width in pixels: 1.5 for Blackman-Harris and Gaussian, 1 for box, 4 for
// Mitchell.
[[nodiscard]] float default_filter_width(FilterKind kind);
// Returns the unnormalized filter along one axis at x pixels from its center: 1 at the center
// except for Mitchell, 0 outside of +-width / 2.
//   blackman_harris  the four-term window (Harris 1978) over the width
//   gaussian         standard deviation width / 6, truncated at three standard deviations
//   mitchell         B = C = 1/3 (Mitchell and Netravali 1988), scaled from width 4 to the width
[[nodiscard]] double filter_value(FilterKind kind, double width, double x);

struct PixelFilterOptions {
  FilterKind kind = FilterKind::blackman_harris;
  float width = 0.0f; // full width in pixels; 0 for the default of the kind
};

// A separable filter with sample density proportional to |f(x) f(y)|, where f is interpolated
// linearly between 129 values on each side. A pixel is the mean of weight times radiance over its
// samples. The mean of the weights is 1; they are exactly 1 for filters without negative lobes, and
// +-c for Mitchell with c = (integral |f| / integral f)^2, about 1.145.
class PixelFilter {
 public:
  template <typename Real>
  struct SampleOf {
    Imath::Vec2<Real> offset; // from the pixel's center, in pixels, each within +-width / 2
    Real weight;
  };
  using Sample = SampleOf<float>;

  explicit PixelFilter(const PixelFilterOptions& options = {});

  // Returns the sample of u in [0, 1)^2. It is monotone in each coordinate, which preserves
  // stratification.
  [[nodiscard]] Sample sample(const V2f& u) const;
  // Eight samples, with the same bits.
  [[nodiscard]] SampleOf<Lanes> sample(const Imath::Vec2<Lanes>& u) const;
  // Returns the density of an offset, per square pixel; 0 outside of the filter.
  [[nodiscard]] float pdf(const V2f& offset) const { return pdf_axis(offset.x) * pdf_axis(offset.y); }

  // Returns the filter at an offset, per square pixel; its integral is 1.
  [[nodiscard]] float value(const V2f& offset) const;

  [[nodiscard]] FilterKind kind() const { return kind_; }
  [[nodiscard]] float width() const { return 2.0f * radius_; }

 private:
  static constexpr uint32_t kCells = 128;
  static constexpr uint32_t kGuideSize = 1024;

  template <typename Real>
  struct AxisSample {
    Real offset;
    Real weight;
  };
  // A cell: its number, the densities at its ends, of |x| per pixel, and their integral up to it.
  template <typename Real>
  struct Cell {
    Real number, density, next_density, below;
  };
  [[nodiscard]] const Cell<float>& find_cell(float v) const;
  [[nodiscard]] const Cell<float>& find_cell(float v, uint32_t entry) const;
  [[nodiscard]] Cell<Lanes> find_cell(const Lanes& v) const;
  template <typename Real>
  [[nodiscard]] AxisSample<Real> sample_axis(const Real& u) const;
  [[nodiscard]] float pdf_axis(float x) const;

  FilterKind kind_;
  float radius_;
  float negative_from_ = kInfinity;                   // |x| beyond which the filter is negative
  float axis_weight_ = 1.0f;                          // integral |f| / integral f
  alignas(16) std::array<Cell<float>, kCells> cells_; // i begins at i * radius / kCells
  std::array<float, kCells> ends_;                    // integrals up to the ends of cells; the last one is 1
  std::array<uint8_t, kGuideSize> guide_;             // cell in which they pass i / kGuideSize: the start of a search
};

} // namespace kindling
