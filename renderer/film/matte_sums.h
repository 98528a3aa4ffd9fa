// Exact coverage of pixels by objects and materials, for Cryptomatte.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/film/aov.h"
#include "renderer/film/film_sums.h"
#include "renderer/film/zeroed_array.h"

#include <compare>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace kindling {

// The ids (cryptomatte.h) of a surface, by Matte; 0 for mattes that are not recorded.
struct MatteIds {
  uint32_t object = 0;
  uint32_t material = 0;
  uint32_t asset = 0;

  [[nodiscard]] uint32_t of(Matte matte) const {
    return matte == Matte::object ? object : matte == Matte::material ? material : asset;
  }
  [[nodiscard]] bool none() const { return (object | material | asset) == 0; }
  auto operator<=>(const MatteIds&) const = default;
};

// The sum of the filter weights of a pixel's samples that meet surfaces with these ids.
struct MatteTerm {
  MatteIds ids;
  uint32_t unused = 0; // 0 in files
  FilmUnitSum weight;
};
static_assert(sizeof(MatteTerm) == 24);

// The terms of all pixels, one after the other, as files have them.
struct FlatMattes {
  std::vector<uint32_t> counts; // of terms, by pixel
  std::vector<MatteTerm> terms; // of each pixel in ascending order of ids
};

// The terms of each pixel of a film: one for each combination of ids that its samples meet, however
// many. Sums are exact and none is ever dropped, so that the terms are a function of the set of
// samples. The first term of a pixel has a place of its own; further ones are taken from a pool
// that grows. A pixel must be written by one thread at a time; different pixels may be written at
// once.
class MatteSums {
 public:
  MatteSums();
  explicit MatteSums(size_t pixels); // throws std::bad_alloc, as all that adds or copies
  MatteSums(const MatteSums& other);
  MatteSums(MatteSums&&) noexcept;
  MatteSums& operator=(MatteSums) noexcept;
  ~MatteSums();

  [[nodiscard]] bool empty() const { return first_.empty(); }
  // Adds a sample; `ids` must not be none().
  void add(size_t pixel, const MatteIds& ids, float weight);
  // Adds the terms of a pixel of other sums.
  void add(size_t pixel, const MatteSums& other, size_t other_pixel);
  // Sets `terms` to those of a pixel, in ascending order of ids.
  void list(size_t pixel, std::vector<MatteTerm>& terms) const;
  [[nodiscard]] size_t memory_bytes() const;

  [[nodiscard]] FlatMattes flat() const;
  // Replaces all terms by those of a file. Files may be wrong: terms without ids, and those beyond
  // the counts, are left out, and equal ones of a pixel are added up.
  void set(const FlatMattes& flat);

 private:
  // A term, and the place of the pixel's next one in the pool, from 1.
  struct Link {
    MatteIds ids; // none(): no sample yet, only of a pixel's first
    uint32_t next = 0;
    FilmUnitSum weight;
  };
  static_assert(sizeof(Link) == 24);
  struct Pool;

  // Returns the sum for these ids.
  [[nodiscard]] FilmUnitSum& term(size_t pixel, const MatteIds& ids);

  ZeroedArray<Link> first_; // by pixel
  std::unique_ptr<Pool> pool_;
};

// Writes the ids with the largest coverage: `ranks.size() / 2` pairs of id and coverage in
// descending order of coverage, equal ones in ascending order of ids; pairs without an id are 0.
// `divisor` is that of the pixel's means. Where a filter has negative lobes, ids with negative
// coverage are left out, and the others are reduced in proportion, so that the sum of all remains
// within [0, 1].
void rank_mattes(std::span<const MatteTerm> terms, Matte matte, double divisor, std::span<float> ranks);

} // namespace kindling
