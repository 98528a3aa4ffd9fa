// Opacity micromaps: answers of alpha tests over parts of triangles, known before a ray asks.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/ray.h"

#include <cstddef>
#include <cstdint>
#include <span>

namespace kindling {

// The answer of an alpha test at all points of an area.
enum class Opacity : uint8_t {
  mixed = 0,       // the texture must be read
  transparent = 1, // every ray passes
  opaque = 2,      // every ray hits
};

// Opacity micromaps (Gruen, Benthin and Woop 2020, "Sub-triangle opacity masks for faster ray
// tracing of transparent objects"): a triangle has 4^level micro-triangles, equal in barycentric
// coordinates, with an Opacity each. Answers are those of a look-up in the texture, whatever it
// rounds.
struct OpacityMicromapsView {
  static constexpr uint32_t kNoMaps = 0xffffffffU;
  static constexpr int kMaxLevel = 6;
  static constexpr uint32_t kLevelBits = 3;      // of an entry; above them is the first word
  static constexpr uint32_t kStatesPerWord = 16; // states have two bits

  // Returns the number of micro-triangles of a level.
  [[nodiscard]] static constexpr uint32_t count(int level) { return 1U << (2 * static_cast<uint32_t>(level)); }

  std::span<const uint32_t> first;   // by mesh: the entry of its first triangle, or kNoMaps; empty: no mesh has maps
  std::span<const uint32_t> entries; // a level and a first word; level 0: a level and the Opacity of the triangle
  std::span<const uint32_t> words;   // states of micro-triangles

  [[nodiscard]] static uint32_t entry_of(int level, uint32_t word) {
    return static_cast<uint32_t>(level) | word << kLevelBits;
  }

  // Returns the number of the micro-triangle at (u, v) among those of a level: rows by v, in each
  // row by u, the upright one of a square before the other. Returns count() for a point that
  // rounding put beyond an edge.
  [[nodiscard]] static uint32_t micro_triangle(float u, float v, int level) {
    const uint32_t rows = 1U << static_cast<uint32_t>(level);
    const float x = u * static_cast<float>(rows), y = v * static_cast<float>(rows);
    const auto column = static_cast<uint32_t>(x), row = static_cast<uint32_t>(y);
    const uint32_t upper = (x - static_cast<float>(column)) + (y - static_cast<float>(row)) > 1.0f ? 1 : 0;
    if (column + row + upper >= rows) return count(level);
    return row * (2 * rows - row) + 2 * column + upper;
  }

  [[nodiscard]] size_t bytes() const { return first.size_bytes() + entries.size_bytes() + words.size_bytes(); }

  // Returns what is known about a hit; u and v are at least 0.
  [[nodiscard]] Opacity at(const accel::Hit& hit) const {
    if (first.empty() || first[hit.mesh] == kNoMaps) return Opacity::mixed;
    const uint32_t entry = entries[first[hit.mesh] + hit.triangle];
    const auto level = static_cast<int>(entry & ((1U << kLevelBits) - 1));
    const uint32_t word = entry >> kLevelBits;
    if (level == 0) return static_cast<Opacity>(word);
    const uint32_t micro = micro_triangle(hit.u, hit.v, level);
    if (micro >= count(level)) return Opacity::mixed;
    return static_cast<Opacity>((words[word + micro / kStatesPerWord] >> (micro % kStatesPerWord * 2)) & 3U);
  }
};

} // namespace kindling
