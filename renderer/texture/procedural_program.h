// The instructions of a compiled procedural texture, and how one evaluation runs.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

class Texture;

// Four channels side by side; a single number stands in all of them.
using Float4 = float __attribute__((vector_size(16)));
// Of its channels, without their signs.
[[nodiscard]] inline float smallest(const Float4& v) {
  return std::min(std::min(std::abs(v[0]), std::abs(v[1])), std::min(std::abs(v[2]), std::abs(v[3])));
}

// What an instruction does with its operands a, b, c, d.
enum class ProceduralOp : uint8_t {
  stream,      // number i[0]
  image,       // texture number i[0] at a; i[1]: fills all channels with red
  noise2d,     // Perlin noise at a, of i[0] channels
  noise3d,     //
  fractal2d,   // i[1] octaves, f[0] lacunarity, f[1] diminish
  fractal3d,   //
  abs_noise2d, // the absolute value of one channel of noise
  abs_noise3d,
  cell2d,
  cell3d,
  worley2d, // f[0] jitter; i[1] style
  worley3d,
  checker, // 1 in the cells of a whose coordinates have an odd sum, else 0
  duty,    // 1 where the part of a beyond its last multiple of f[0] is below f[1], else 0
  add,
  subtract,
  multiply,
  divide,
  modulo,
  absolute,
  sign,
  floor,
  ceil,
  round,
  fract,
  power,
  sqrt,
  exp,
  ln,
  sin,
  cos,
  tan,
  asin,
  acos,
  atan2,
  min,
  max,
  mix,        // b + (a - b) c
  smoothstep, // of a between b and c
  dot,        // of i[0] channels
  cross,
  normalize, // of i[0] channels
  greater,   // a > b ? c : d
  greater_equal,
  equal,
  swizzle, // channel k is channel i[k] & 3 of operand i[k] >> 2
};

// How the coordinates of a pattern follow from one stream: channel k changes by the scalar product of m[k] with the stream's change.
struct ProceduralFootprint {
  int stream = -1;
  float m[3][3] = {};
};

struct ProceduralInstruction {
  ProceduralOp op = ProceduralOp::add;
  uint8_t channels = 4;              // 1: compute one and fill all
  bool filtered = false;             // by `footprint`: the mean over it
  std::array<int16_t, 4> operands{}; // >= 0: the result of that instruction; else constant ~operand
  std::array<int16_t, 4> i{};
  std::array<float, 2> f{};
  int16_t footprint = -1;      // index; -1: unknown
  std::array<float, 4> mean{}; // of a pattern
};

struct ProceduralProgram {
  std::vector<ProceduralInstruction> instructions; // each reads earlier ones; at most kMaxProceduralInstructions
  std::vector<Float4> constants;
  std::vector<ProceduralFootprint> footprints;
  int16_t result = 0; // operand
  bool filters_itself = true;
  // Of what is not filtered by itself: how many features lie along a unit of each stream.
  std::vector<float> frequencies;
};

inline constexpr size_t kMaxProceduralInstructions = 1024;

// The values of streams at one point, and their changes across the footprint times `scale`.
struct ProceduralPoint {
  std::span<const Float4> values;
  std::span<const std::array<Float4, 2>> across;
  float scale = 0.0f; // 0: unfiltered
};

// One evaluation. `textures` are those that images number.
[[nodiscard]] Float4 run(const ProceduralProgram& program, const ProceduralPoint& point,
                         std::span<const Texture> textures);
// One instruction; `operands` are its values.
[[nodiscard]] Float4 run(const ProceduralInstruction& instruction, const std::array<Float4, 4>& operands,
                         const ProceduralProgram& program, const ProceduralPoint& point,
                         std::span<const Texture> textures);

} // namespace kindling
