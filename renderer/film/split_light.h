// Sums of parts of the light of a pixel that add up to its beauty exactly.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/film/aov.h"
#include "renderer/film/film_sums.h"
#include "renderer/film/film_surface.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace kindling {

// Sum of one part of the radiance.
struct RadianceSum {
  FilmSum rgb[3];

  void add(const RadianceSum& other) {
    for (int c = 0; c < 3; ++c) rgb[c].add(other.rgb[c]);
  }
};
static_assert(sizeof(RadianceSum) == 48);

// The places of the passes in an AOV set among the sums of a pixel.
struct LightPassPlaces {
  static constexpr uint8_t kNotStored = 0xff;
  std::array<uint8_t, kLightPassCount> of_pass{}; // or kNotStored
  uint8_t count = 0;

  LightPassPlaces() { of_pass.fill(kNotStored); }
  explicit LightPassPlaces(AovSet aovs) {
    for (size_t pass = 0; pass < kLightPassCount; ++pass)
      of_pass[pass] = aovs.contains(static_cast<LightPass>(pass)) ? count++ : kNotStored;
  }
};

// The passes that light paths add to: their light has been reflected before.
inline constexpr std::array kSplatPasses{LightPass::diffuse_indirect, LightPass::glossy_indirect,
                                         LightPass::transmission_indirect};

// The parts of the light that a light path's belongs to.
struct SplatParts {
  uint8_t group = 0; // index into Film::light_groups()
  // Fractions of kSplatPasses by channel, which sum to 1 up to rounding.
  std::array<Rgb, kSplatPasses.size()> passes{Rgb(0.0f), Rgb(0.0f), Rgb(0.0f)};
};

// Sums of the albedos of the lobes of the first surface.
struct LobeColorSum {
  FilmUnitSum diffuse[3];
  FilmUnitSum glossy[3];
  FilmUnitSum transmission[3];

  void add(const LobeColors& colors, float weight) {
    const double w = weight;
    for (int c = 0; c < 3; ++c) {
      diffuse[c].add(w * static_cast<double>(colors.diffuse[c]));
      glossy[c].add(w * static_cast<double>(colors.glossy[c]));
      transmission[c].add(w * static_cast<double>(colors.transmission[c]));
    }
  }
  void add(const LobeColorSum& other) {
    for (int c = 0; c < 3; ++c) {
      diffuse[c].add(other.diffuse[c]);
      glossy[c].add(other.glossy[c]);
      transmission[c].add(other.transmission[c]);
    }
  }
};
static_assert(sizeof(LobeColorSum) == 72);

// Splits what PixelSum::add() adds for a sample of that radiance among its parts, which are the
// radiance's summands up to rounding: calls add(part, channel, FilmSum) for the terms of parts that
// are not black. The terms sum to that of the radiance exactly: the difference that rounding leaves
// goes to the part with the largest magnitude (of equal ones the first), channel by channel.
// `part_at(part)` returns one of `count` parts.
template <typename PartAt, typename Add>
void split_sample(size_t count, const PartAt& part_at, const Rgb& radiance, float weight, const Add& add) {
  const double w = weight;
  for (int c = 0; c < 3; ++c) {
    FilmSum rest;
    rest.add(w * static_cast<double>(radiance[c]));
    size_t largest = 0;
    float magnitude = count > 0 ? std::abs(part_at(0)[c]) : 0.0f;
    for (size_t i = 1; i < count; ++i)
      if (const float other = std::abs(part_at(i)[c]); other > magnitude) {
        magnitude = other;
        largest = i;
      }
    for (size_t i = 0; i < count; ++i) {
      const float part = part_at(i)[c];
      if (part == 0.0f || i == largest) continue;
      FilmSum term;
      term.add(w * static_cast<double>(part));
      rest.subtract(term);
      add(i, c, term);
    }
    add(largest, c, rest);
  }
}

} // namespace kindling
