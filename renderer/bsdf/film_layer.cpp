// Fresnel of a film below a coat, and its means over lobes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/film_layer.h"

#include "renderer/base/on_gpu.h"
#include "renderer/bsdf/bsdf_ranges.h"
#include "renderer/bsdf/fast_pow.h"

namespace kindling {

FilmLayer::FilmLayer(const LayerParameters& layers, const Rgb& base_f0)
    : film_(1.0f + 0.5f * layers.clearcoat, layers.iridescence_ior, base_f0, layers.iridescence_thickness_nm),
      outside_ior_(1.0f + 0.5f * layers.clearcoat) {}

float FilmLayer::schlick(const GgxAlbedo& seen) const {
  const float x = seen.e > 0.0f ? std::min(seen.b / seen.e, 1.0f) : 0.0f;
  return outside_ior_ > 1.0f ? pow5(1.0f - refracted_cosine(1.0f - fast_pow(x, 0.2f), outside_ior_)) : x;
}

Rgb FilmLayer::fresnel(const GgxAlbedo& seen) const { return film_.fresnel(1.0f - fast_pow(schlick(seen), 0.2f)); }

Rgb FilmLayer::f0(const GgxAlbedo& seen) const {
  const float x = std::min(schlick(seen), 0.999f);
  return saturate((fresnel(seen) - Rgb(x)) / (1.0f - x));
}

namespace {

// Returns the film's Fresnel at the cosine of each node: in lanes, where there are any.
std::array<Rgb, kFilmNodes> node_fresnels(const FilmLayer& film) {
  std::array<Rgb, kFilmNodes> fresnels;
#if KINDLING_ON_GPU
  for (uint32_t k = 0; k < kFilmNodes; ++k) fresnels[k] = film.fresnel(film_node_cosine(k));
#else
  static_assert(kFilmNodes % Lanes::kCount == 0);
  for (uint32_t first = 0; first < kFilmNodes; first += Lanes::kCount) {
    LaneNumbers cosines;
    LaneVectors values;
    for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) cosines[lane] = film_node_cosine(first + lane);
    values.store(film.fresnel(cosines.load()));
    for (uint32_t lane = 0; lane < Lanes::kCount; ++lane) fresnels[first + lane] = values[lane];
  }
#endif
  return fresnels;
}

} // namespace

FilmAlbedo::FilmAlbedo(const FilmLayer& film, float roughness) {
  schlick_share_ = pow5(1.0f - film.cosine_below_coat(0.0f));
  const std::array<Rgb, kFilmNodes> fresnels = node_fresnels(film);
  std::array<Nodes, 3> values; // Fresnel without Schlick's rise, at the cosines of the nodes
  Rgb sum(0.0f);
  float weights = 0.0f;
  for (uint32_t k = 0; k < kFilmNodes; ++k) {
    const float cosine = film_node_cosine(k);
    const Rgb f = fresnels[k] - Rgb(schlick_share_ * pow5(1.0f - cosine));
    for (int c = 0; c < 3; ++c) values[static_cast<size_t>(c)][k] = f[c];
    const float weight = film_node_area(k);
    sum += f * weight;
    weights += weight;
  }
  mean_fresnel_ = sum / weights + Rgb(schlick_share_ * (1.0f / 21.0f));

  const float y = (roughness - kMinRoughness) * ((kFilmRoughnessNodes - 1) / (1.0f - kMinRoughness));
  const auto row = cell_of(y, kFilmRoughnessNodes - 2);
  const float upper = (y - static_cast<float>(row)) * (1.0f / 65535.0f);
  const float lower = 1.0f / 65535.0f - upper;
  const uint16_t* low = kFilmTable + row * (kFilmNodes * kFilmNodes);
  const uint16_t* high = low + kFilmNodes * kFilmNodes;
  for (Nodes& channel : residual_) channel.fill(0.0f);
  for (uint32_t k = 0; k < kFilmNodes; ++k) {
    for (uint32_t m = 0; m < kFilmNodes; ++m) {
      const float weight =
          lower * static_cast<float>(low[k * kFilmNodes + m]) + upper * static_cast<float>(high[k * kFilmNodes + m]);
      residual_[0][m] += weight * values[0][k];
      residual_[1][m] += weight * values[1][k];
      residual_[2][m] += weight * values[2][k];
    }
  }
}

Rgb FilmAlbedo::residual(float mu) const {
  const Position at = position(mu);
  return lerp(residual(at.node), residual(at.node + 1), at.fraction);
}

} // namespace kindling
