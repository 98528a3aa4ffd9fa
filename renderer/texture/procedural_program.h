// Instructions of compiled procedural textures, and their evaluation.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/base/simd_types.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

namespace kindling {

struct TextureView;

// Values are a Float4 of channels; a single number fills all of them.

// Returns the minimum of the magnitudes of the channels.
[[nodiscard]] inline float min_magnitude(const Float4& v) {
  return std::min(std::min(std::abs(v[0]), std::abs(v[1])), std::min(std::abs(v[2]), std::abs(v[3])));
}

// The operation of an instruction on its operands a, b, c, d.
enum class ProceduralOp : uint8_t {
  stream,      // stream number i[0]
  image,       // texture number i[0] at a; if i[1] is not 0, red fills all channels
  noise2d,     // Perlin noise at a, with i[0] channels
  noise3d,     //
  fractal2d,   // i[1] octaves, f[0] lacunarity, f[1] diminish
  fractal3d,   //
  abs_noise2d, // the absolute value of single-channel noise
  abs_noise3d,
  cell2d,
  cell3d,
  worley2d, // f[0] jitter; i[1] style
  worley3d,
  checker, // 1 in unit cells at a whose coordinates have an odd sum, else 0
  duty,    // 1 where a modulo f[0] is below f[1], else 0
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
  smoothstep, // smoothstep of a from b to c
  dot,        // scalar product of i[0] channels
  cross,
  normalize, // normalizes i[0] channels
  greater,   // a > b ? c : d
  greater_equal,
  equal,
  swizzle, // channel k is channel i[k] & 3 of operand i[k] >> 2
};

// Linear dependence of the coordinates of a pattern on one stream: channel k changes by the scalar
// product of m[k] with the change of the stream.
struct ProceduralFootprint {
  int stream = -1;
  float m[3][3] = {};
};

struct ProceduralInstruction {
  ProceduralOp op = ProceduralOp::add;
  uint8_t channels = 4;  // 1: computes one channel and fills all
  bool filtered = false; // true: the result is the mean over the footprint
  // >= 0: result of that instruction, in a finished program the register; < 0: constant ~operand
  std::array<int16_t, 4> operands{};
  int16_t target = 0; // register of the result, which may be that of an operand
  std::array<int16_t, 4> i{};
  std::array<float, 2> f{};
  int16_t footprint = -1;      // index into the footprints of the program; -1: unknown
  std::array<float, 4> mean{}; // mean of the pattern over all of space
};

// A program as evaluation reads it.
struct ProceduralProgramView {
  std::span<const ProceduralInstruction> instructions; // in order of dependence; at most kMaxProceduralInstructions
  std::span<const Float4> constants;
  std::span<const ProceduralFootprint> footprints;
  // Features without an analytic filter, for each stream their number per unit of the stream.
  std::span<const float> frequencies;
  int16_t result = 0;         // operand
  int16_t register_count = 0; // at most kMaxProceduralRegisters
  bool filters_itself = true; // true: all features are filtered analytically
};

// A program while it is compiled; the members are those of the view.
struct ProceduralProgram {
  std::vector<ProceduralInstruction> instructions;
  std::vector<Float4> constants;
  std::vector<ProceduralFootprint> footprints;
  std::vector<float> frequencies;
  int16_t result = 0;
  int16_t register_count = 0;
  bool filters_itself = true;

  [[nodiscard]] ProceduralProgramView view() const {
    return {instructions, constants, footprints, frequencies, result, register_count, filters_itself};
  }
};

inline constexpr size_t kMaxProceduralInstructions = 1024;
inline constexpr size_t kMaxProceduralRegisters = 64; // a GPU keeps them for each thread

// The values of all streams at a point. The footprint is given by their changes across it times
// `scale`.
struct ProceduralPoint {
  std::span<const Float4> values;
  std::span<const std::array<Float4, 2>> across;
  float scale = 0.0f; // 0 for no filtering
};

// Evaluates a program at a point. Images refer to `textures` by index.
[[nodiscard]] Float4 run(const ProceduralProgramView& program, const ProceduralPoint& point,
                         std::span<const TextureView> textures);
// Evaluates one instruction, given the values of its operands.
[[nodiscard]] Float4 run(const ProceduralInstruction& instruction, const std::array<Float4, 4>& operands,
                         const ProceduralProgramView& program, const ProceduralPoint& point,
                         std::span<const TextureView> textures);

} // namespace kindling
