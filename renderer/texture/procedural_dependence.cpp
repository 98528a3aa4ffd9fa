// Dependence of values on the streams: exact for linear functions, an estimated gain for others.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/procedural_emitter.h"

#include <algorithm>
#include <cmath>

namespace kindling {
namespace {

using Op = ProceduralOp;

float norm(const float (&row)[3]) { return std::sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]); }

float max_magnitude(const Float4& v) {
  return std::max(std::max(std::abs(v[0]), std::abs(v[1])), std::max(std::abs(v[2]), std::abs(v[3])));
}

} // namespace

ProceduralDependence ProceduralEmitter::dependence_of(int16_t operand) const {
  if (operand >= 0) return dependences_[static_cast<size_t>(operand)];
  ProceduralDependence none;
  none.affine = true;
  return none;
}

ProceduralDependence ProceduralEmitter::depend(const ProceduralInstruction& instruction) const {
  ProceduralDependence result;
  std::array<ProceduralDependence, 4> from;
  for (size_t k = 0; k < 4; ++k) from[k] = dependence_of(instruction.operands[k]);
  const auto constant = [&](size_t k) { return is_constant(instruction.operands[k]); };
  const auto value = [&](size_t k) { return value_of(instruction.operands[k]); };

  // Linear functions of one stream.
  const auto share_stream = [&](size_t count) {
    result.affine = true;
    for (size_t k = 0; k < count; ++k) {
      result.affine &= from[k].affine && (from[k].stream < 0 || result.stream < 0 || from[k].stream == result.stream);
      if (from[k].stream >= 0) result.stream = from[k].stream;
    }
  };
  const auto fill_rows = [&](auto&& entry) {
    for (size_t row = 0; row < 4; ++row)
      for (size_t column = 0; column < 3; ++column) result.m[row][column] = entry(row, column);
  };
  switch (instruction.op) {
  case Op::stream:
    result.affine = true;
    result.stream = instruction.i[0];
    for (size_t k = 0; k < 3; ++k) result.m[k][k] = 1.0f;
    break;
  case Op::add:
  case Op::subtract:
    share_stream(2);
    fill_rows([&](size_t r, size_t c) {
      return from[0].m[r][c] + (instruction.op == Op::add ? from[1].m[r][c] : -from[1].m[r][c]);
    });
    break;
  case Op::multiply:
    if (!constant(0) && !constant(1)) break;
    share_stream(2);
    fill_rows([&](size_t r, size_t c) {
      return constant(0) ? value(0)[r] * from[1].m[r][c] : value(1)[r] * from[0].m[r][c];
    });
    break;
  case Op::divide:
    if (!constant(1) || min_magnitude(value(1)) == 0.0f) break;
    share_stream(1);
    fill_rows([&](size_t r, size_t c) { return from[0].m[r][c] / value(1)[r]; });
    break;
  case Op::dot: {
    if (!constant(0) && !constant(1)) break;
    share_stream(2);
    const size_t varying = constant(0) ? 1 : 0;
    fill_rows([&](size_t, size_t c) {
      float sum = 0.0f;
      for (size_t k = 0; k < static_cast<size_t>(instruction.i[0]); ++k)
        sum += value(1 - varying)[k] * from[varying].m[k][c];
      return sum;
    });
    break;
  }
  case Op::swizzle:
    share_stream(4);
    fill_rows([&](size_t r, size_t c) {
      const auto source = static_cast<size_t>(instruction.i[r]);
      return from[source >> 2U].m[source & 3U][c];
    });
    break;
  default: break;
  }
  if (!result.affine) result.stream = -1;
  if (result.affine && result.stream >= 0) {
    float max_norm = 0.0f;
    for (const auto& row : result.m) max_norm = std::max(max_norm, norm(row));
    result.gain[static_cast<size_t>(result.stream)] = max_norm;
    return result;
  }

  // Other functions: an estimate of their steepness.
  float steepness = 1.0f;
  switch (instruction.op) {
  case Op::noise2d:
  case Op::noise3d:
  case Op::abs_noise2d:
  case Op::abs_noise3d: steepness = 2.0f; break;
  case Op::fractal2d:
  case Op::fractal3d: {
    float octave = 2.0f;
    steepness = 0.0f;
    for (int k = 0; k < instruction.i[1]; ++k, octave *= std::abs(instruction.f[0] * instruction.f[1]))
      steepness += octave;
    break;
  }
  case Op::multiply:
    if (constant(0) || constant(1)) steepness = max_magnitude(value(constant(0) ? 0 : 1));
    break;
  case Op::divide:
    if (constant(1)) steepness = 1.0f / std::max(min_magnitude(value(1)), 1e-6f);
    break;
  case Op::power:
    if (constant(1)) steepness = std::max(1.0f, max_magnitude(value(1)));
    break;
  case Op::smoothstep:
    if (constant(1) && constant(2)) steepness = 1.5f / std::max(max_magnitude(value(2) - value(1)), 1e-6f);
    break;
  case Op::mix:
    if (constant(0) && constant(1)) steepness = max_magnitude(value(0) - value(1));
    break;
  default: break;
  }
  for (size_t k = 0; k < 4; ++k)
    for (size_t s = 0; s < kProceduralStreams; ++s)
      result.gain[s] = std::min(result.gain[s] + steepness * from[k].gain[s], 1e9f);
  return result;
}

} // namespace kindling
