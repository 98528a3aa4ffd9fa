// Classifies texels by an alpha test, and finds what rows of them have in common.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/opacity/alpha_classes.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>

namespace kindling {
namespace {

// Blending values up to 1 three times rounds by a few units of 2^-24.
constexpr double kBlendError = 0x1p-20;

Opacity classify(float alpha, const AlphaTest& test) {
  if (!(alpha >= 0.0f && alpha <= 1.0f)) return Opacity::mixed; // float images: beside such texels the error is larger
  if (test.mode == AlphaMode::blend) {
    if (alpha == 0.0f) return Opacity::transparent;
    return alpha == 1.0f && test.factor == 1.0f ? Opacity::opaque : Opacity::mixed;
  }
  const double margin = kBlendError * (double{test.factor} + test.cutoff);
  const double seen = double{alpha} * test.factor;
  if (seen + margin < test.cutoff) return Opacity::transparent;
  return seen - margin >= test.cutoff ? Opacity::opaque : Opacity::mixed;
}

// Returns the column or row of the image that is read for one outside of it.
int wrapped(int64_t at, int size, TextureWrap wrap) {
  if (wrap == TextureWrap::clamp_to_edge) return static_cast<int>(std::clamp<int64_t>(at, 0, size - 1));
  const int64_t period = wrap == TextureWrap::repeat ? size : 2 * int64_t{size};
  const int64_t rest = ((at % period) + period) % period;
  return static_cast<int>(rest < size ? rest : period - 1 - rest);
}

} // namespace

AlphaClasses::AlphaClasses(const TextureView& texture, const AlphaTest& test)
    : width_(texture.size_px().x), height_(texture.size_px().y), wrap_u_(texture.wrap_u), wrap_v_(texture.wrap_v),
      row_words_(row_words(width_)), transparent_(row_words_ * static_cast<size_t>(height_)),
      opaque_(transparent_.size()) {
  tbb::parallel_for(tbb::blocked_range<int>(0, height_, 64), [&](const tbb::blocked_range<int>& rows) {
    std::vector<float> alphas(static_cast<size_t>(width_));
    for (int y = rows.begin(); y < rows.end(); ++y) {
      texture.alphas_of_row(y, alphas);
      for (size_t x = 0; x < alphas.size(); ++x) {
        const Opacity found = classify(alphas[x], test);
        const size_t word = static_cast<size_t>(y) * row_words_ + x / 64;
        transparent_[word] |= uint64_t{found == Opacity::transparent} << (x % 64);
        opaque_[word] |= uint64_t{found == Opacity::opaque} << (x % 64);
      }
    }
  });
}

bool AlphaClasses::all_set(const std::vector<uint64_t>& bits, int y, int x0, int x1) const {
  const uint64_t* row = bits.data() + static_cast<size_t>(y) * row_words_;
  const int first = x0 / 64, last = x1 / 64;
  for (int word = first; word <= last; ++word) {
    uint64_t wanted = ~uint64_t{0};
    if (word == first) wanted &= ~uint64_t{0} << (x0 % 64);
    if (word == last) wanted &= ~uint64_t{0} >> (63 - x1 % 64);
    if ((row[word] & wanted) != wanted) return false;
  }
  return true;
}

Opacity AlphaClasses::of_columns(int y, int x0, int x1) const {
  if (all_set(transparent_, y, x0, x1)) return Opacity::transparent;
  return all_set(opaque_, y, x0, x1) ? Opacity::opaque : Opacity::mixed;
}

Opacity AlphaClasses::of_row(int64_t y, int64_t x0, int64_t x1) const {
  const int row = wrapped(y, height_, wrap_v_);
  if (x1 - x0 + 1 >= 2 * int64_t{width_}) return of_columns(row, 0, width_ - 1);
  Opacity common = Opacity::mixed;
  for (int64_t from = x0; from <= x1;) {
    // The rest of the period that begins at `from`, or one texel of an axis that is mirrored.
    const int column = wrapped(from, width_, wrap_u_);
    int64_t to = from;
    if (wrap_u_ == TextureWrap::repeat) to = std::min<int64_t>(x1, from + (width_ - 1 - column));
    if (wrap_u_ == TextureWrap::clamp_to_edge && from >= 0 && from < width_) to = std::min<int64_t>(x1, width_ - 1);
    const Opacity part = of_columns(row, column, column + static_cast<int>(to - from));
    if (part == Opacity::mixed || (from > x0 && part != common)) return Opacity::mixed;
    common = part;
    from = to + 1;
  }
  return common;
}

} // namespace kindling
