// Sums of the light on shadow catchers, with the objects that shade them and without.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/film/film_sums.h"

#include <algorithm>
#include <cstdint>

namespace kindling {

// A sample whose first surface belongs to a shadow catcher.
struct CaughtLight {
  Rgb shadowed{0.0f};   // its radiance in the whole scene
  Rgb unshadowed{0.0f}; // the same where there are no objects but catchers and lamps
};

// Over the samples of a pixel whose first surface belongs to a shadow catcher.
struct CatcherSum {
  FilmSum shadowed[3];
  FilmSum unshadowed[3];
  FilmUnitSum weight;

  void add(const CaughtLight& light, float sample_weight) {
    const double w = sample_weight;
    for (int c = 0; c < 3; ++c) {
      shadowed[c].add(w * static_cast<double>(light.shadowed[c]));
      unshadowed[c].add(w * static_cast<double>(light.unshadowed[c]));
    }
    weight.add(w);
  }
  void add(const CatcherSum& other) {
    for (int c = 0; c < 3; ++c) {
      shadowed[c].add(other.shadowed[c]);
      unshadowed[c].add(other.unshadowed[c]);
    }
    weight.add(other.weight);
  }

  // Returns the part of the catcher's light that arrives; above 1 where objects reflect light to
  // it. 1 where it would be black anyway.
  [[nodiscard]] double lit(int channel) const {
    const double whole = unshadowed[channel].value();
    return whole > 0.0 ? std::max(shadowed[channel].value() / whole, 0.0) : 1.0;
  }
  // Returns the mean over the channels of 1 - lit(), which is at least 0: the opacity of a black
  // layer that shows the shadow.
  [[nodiscard]] double shadow() const {
    double lit_channels = 0.0;
    for (int c = 0; c < 3; ++c) lit_channels += std::min(lit(c), 1.0);
    return 1.0 - lit_channels / 3.0;
  }
};
static_assert(sizeof(CatcherSum) == 104);

} // namespace kindling
