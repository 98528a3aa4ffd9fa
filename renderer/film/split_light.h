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
#include <span>

namespace kindling {

// Sum of one part of the radiance.
struct RadianceSum {
  FilmSum rgb[3];

  void add(const RadianceSum& other) {
    for (int c = 0; c < 3; ++c) rgb[c].add(other.rgb[c]);
  }
};
static_assert(sizeof(RadianceSum) == 48);

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
template <typename Add>
void split_sample(std::span<const Rgb> parts, const Rgb& radiance, float weight, const Add& add) {
  const double w = weight;
  for (int c = 0; c < 3; ++c) {
    FilmSum rest;
    rest.add(w * static_cast<double>(radiance[c]));
    size_t largest = 0;
    for (size_t i = 1; i < parts.size(); ++i)
      if (std::abs(parts[i][c]) > std::abs(parts[largest][c])) largest = i;
    for (size_t i = 0; i < parts.size(); ++i) {
      if (parts[i][c] == 0.0f || i == largest) continue;
      FilmSum term;
      term.add(w * static_cast<double>(parts[i][c]));
      rest.subtract(term);
      add(i, c, term);
    }
    add(largest, c, rest);
  }
}

} // namespace kindling
