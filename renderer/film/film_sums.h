// Exact sums over the samples of a pixel, the records of the Film.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/exact_sum.h"
#include "renderer/base/math.h"

#include <cstdint>

namespace kindling {

// Ranges and units are derived in README.md.
// Sums of radiance and of lengths in meters, in multiples of 2^-55; terms are within +-2^40.
using FilmSum = ExactSum<55, 40>;
// Sums of weights, and of weights times values in [-1, 1], in multiples of 2^-28; terms are within
// +-8.
using FilmUnitSum = ExactSmallSum<28, 3>;

// Sums of every film: beauty, alpha, weights and the number of samples.
struct PixelSum {
  FilmSum rgb[3];
  FilmUnitSum alpha;
  FilmUnitSum weight;
  uint64_t samples = 0;

  void add(const Rgb& radiance, float sample_alpha, float sample_weight) {
    // A product of two floats is exact in double precision.
    const double w = sample_weight;
    for (int c = 0; c < 3; ++c) rgb[c].add(w * static_cast<double>(radiance[c]));
    alpha.add(w * static_cast<double>(sample_alpha));
    weight.add(w);
    samples += 1;
  }
  void add(const PixelSum& other) {
    for (int c = 0; c < 3; ++c) rgb[c].add(other.rgb[c]);
    alpha.add(other.alpha);
    weight.add(other.weight);
    samples += other.samples;
  }
};
static_assert(sizeof(PixelSum) == 72);

// Light of light paths (renderer/integrator) that reached a pixel, whichever pixel's samples they
// belong to.
struct SplatSum {
  FilmSum rgb[3];     // radiance, not yet divided by the number of paths
  uint64_t paths = 0; // that count for the whole film, in any distribution among its pixels

  void add(const SplatSum& other) {
    for (int c = 0; c < 3; ++c) rgb[c].add(other.rgb[c]);
    paths += other.paths;
  }
};
static_assert(sizeof(SplatSum) == 56);

// Moments of a weighted value y, for the variance of the ratio sum(w y) / sum(w).
struct MomentSum {
  FilmSum w2;
  FilmSum w2_y;
  ExactSquareSum w2_y2;

  void add(float y, float weight) {
    const double w2_of_sample = static_cast<double>(weight) * static_cast<double>(weight);
    const double w2_y_of_sample = w2_of_sample * static_cast<double>(y);
    w2.add(w2_of_sample);
    w2_y.add(w2_y_of_sample);
    w2_y2.add(w2_y_of_sample * static_cast<double>(y));
  }
  void add(const MomentSum& other) {
    w2.add(other.w2);
    w2_y.add(other.w2_y);
    w2_y2.add(other.w2_y2);
  }
};
static_assert(sizeof(MomentSum) == 56);

// Sums of the attributes of the first surface, over the samples that hit one.
struct SurfaceSum {
  FilmSum position[3];
  FilmSum depth;
  FilmUnitSum albedo[3];
  FilmUnitSum normal[3];
  FilmUnitSum hit_weight;
  uint64_t hits = 0;

  void add(const Rgb& sample_albedo, const V3f& sample_normal, const V3f& sample_position, float sample_depth,
           float weight) {
    const double w = weight;
    for (int c = 0; c < 3; ++c) {
      position[c].add(w * static_cast<double>(sample_position[c]));
      albedo[c].add(w * static_cast<double>(sample_albedo[c]));
      normal[c].add(w * static_cast<double>(sample_normal[c]));
    }
    depth.add(w * static_cast<double>(sample_depth));
    hit_weight.add(w);
    hits += 1;
  }
  void add(const SurfaceSum& other) {
    for (int c = 0; c < 3; ++c) {
      position[c].add(other.position[c]);
      albedo[c].add(other.albedo[c]);
      normal[c].add(other.normal[c]);
    }
    depth.add(other.depth);
    hit_weight.add(other.hit_weight);
    hits += other.hits;
  }
};
static_assert(sizeof(SurfaceSum) == 128);

// Sums of what guides denoisers, over the samples that hit a surface.
struct GuideSum {
  FilmUnitSum albedo[3];
  FilmUnitSum normal[3];

  void add(const Rgb& sample_albedo, const V3f& sample_normal, float weight) {
    const double w = weight;
    for (int c = 0; c < 3; ++c) {
      albedo[c].add(w * static_cast<double>(sample_albedo[c]));
      normal[c].add(w * static_cast<double>(sample_normal[c]));
    }
  }
  void add(const GuideSum& other) {
    for (int c = 0; c < 3; ++c) {
      albedo[c].add(other.albedo[c]);
      normal[c].add(other.normal[c]);
    }
  }
};
static_assert(sizeof(GuideSum) == 48);

// Sums of components of the radiance.
struct ComponentSum {
  FilmSum emission[3];
  FilmSum direct[3];

  void add(const Rgb& sample_emission, const Rgb& sample_direct, float weight) {
    const double w = weight;
    for (int c = 0; c < 3; ++c) {
      emission[c].add(w * static_cast<double>(sample_emission[c]));
      direct[c].add(w * static_cast<double>(sample_direct[c]));
    }
  }
  void add(const ComponentSum& other) {
    for (int c = 0; c < 3; ++c) {
      emission[c].add(other.emission[c]);
      direct[c].add(other.direct[c]);
    }
  }
};
static_assert(sizeof(ComponentSum) == 96);

// Sums of radiance and weight only, for a block of samples (outliers.h).
struct ColorSum {
  FilmSum rgb[3];
  FilmUnitSum weight;

  void add(const Rgb& radiance, float sample_weight) {
    const double w = sample_weight;
    for (int c = 0; c < 3; ++c) rgb[c].add(w * static_cast<double>(radiance[c]));
    weight.add(w);
  }
  void add(const ColorSum& other) {
    for (int c = 0; c < 3; ++c) rgb[c].add(other.rgb[c]);
    weight.add(other.weight);
  }
  void subtract(const ColorSum& other) {
    for (int c = 0; c < 3; ++c) rgb[c].subtract(other.rgb[c]);
    weight.subtract(other.weight);
  }
};
static_assert(sizeof(ColorSum) == 56);

} // namespace kindling
