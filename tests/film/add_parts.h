// Adds the parts of a sample's light to films.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/film.h"

#include <cstddef>
#include <span>

namespace kindling {

inline void add_light_groups(Film& film, const V2i& pixel, std::span<const Rgb> parts, const FilmSample& sample) {
  film.view().add_light_groups(film.index_of(pixel), sample, [&](size_t group) { return parts[group]; });
}
inline void add_light_passes(Film& film, const V2i& pixel, std::span<const Rgb> parts, const FilmSample& sample) {
  film.view().add_light_passes(film.index_of(pixel), sample, [&](size_t pass) { return parts[pass]; });
}

} // namespace kindling
