// Emission of procedural instructions: folding, fusion, dead-code elimination, choice of filters.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/procedural_emitter.h"

#include "renderer/base/elementary.h"
#include "renderer/base/hash.h"
#include "renderer/texture/noise.h"
#include "renderer/texture/procedural_registers.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <cstring>
#include <utility>

namespace kindling {
namespace {

using Op = ProceduralOp;

// Returns true for patterns over all of space, which have filters of their own.
bool is_pattern(const ProceduralInstruction& instruction) {
  switch (instruction.op) {
  case Op::noise2d:
  case Op::noise3d:
  case Op::fractal2d:
  case Op::fractal3d:
  case Op::abs_noise2d:
  case Op::abs_noise3d:
  case Op::cell2d:
  case Op::cell3d:
  case Op::worley2d:
  case Op::worley3d:
  case Op::checker:
  case Op::duty: return true;
  case Op::sin:
  case Op::cos: return instruction.channels == 1;
  default: return false;
  }
}

// Returns true if the mean of the result equals the result of the mean of the operand.
bool is_linear_in(const ProceduralInstruction& instruction, size_t operand) {
  const auto constant = [&](size_t k) { return instruction.operands[k] < 0; };
  switch (instruction.op) {
  case Op::add:
  case Op::subtract:
  case Op::swizzle: return true;
  case Op::multiply:
  case Op::dot: return constant(1 - operand);
  case Op::divide: return operand == 0 && constant(1);
  case Op::mix: return operand == 2 ? constant(0) && constant(1) : constant(2);
  default: return false;
  }
}

// Returns point i of a low-discrepancy sequence (Roberts 2018, "The Unreasonable Effectiveness of
// Quasirandom Sequences": R3).
V3f spread_point(uint32_t i) {
  return V3f(to_unit_float(i * 0xd1b54a33U), to_unit_float(i * 0xabc98389U), to_unit_float(i * 0x8cb92ba7U)) * 97.0f;
}

std::array<float, 4> mean_of_worley(const ProceduralInstruction& instruction) {
  V3f sum(0.0f);
  constexpr uint32_t kPoints = 8192;
  for (uint32_t k = 0; k < kPoints; ++k) {
    const V3f p = spread_point(k);
    V2f nearest2;
    V3f nearest3;
    sum += instruction.op == Op::worley2d ? noise::worley(V2f(p.x, p.y), instruction.f[0], nearest2)
                                          : noise::worley(p, instruction.f[0], nearest3);
  }
  const V3f mean = sum / static_cast<float>(kPoints);
  if (instruction.i[0] == 1) return {mean.x, mean.x, mean.x, mean.x};
  return {mean.x, mean.y, mean.z, 1.0f};
}

// Means of |noise|, measured over 2^24 random points each, with standard errors of 4e-5.
constexpr float kMeanAbsolute2d = 0.2598f;
constexpr float kMeanAbsolute3d = 0.2163f;

// Sets the mean of a pattern. `others` are the instructions of the program: an equal later one
// already has its mean.
void set_mean(ProceduralInstruction& instruction, const std::vector<ProceduralInstruction>& others) {
  const auto all = [&](float mean) {
    instruction.mean = {mean, mean, mean, mean};
    if (instruction.i[0] > 1 && instruction.i[0] < 4) instruction.mean[3] = 1.0f;
  };
  switch (instruction.op) {
  case Op::noise2d:
  case Op::noise3d: all(0.0f); break;
  case Op::abs_noise2d: all(kMeanAbsolute2d); break;
  case Op::abs_noise3d: all(kMeanAbsolute3d); break;
  case Op::cell2d:
  case Op::cell3d: all(0.5f); break;
  case Op::worley2d:
  case Op::worley3d:
    if (instruction.i[1] == 1) {
      all(0.5f);
    } else {
      const auto same = std::find_if(others.begin(), others.end(), [&](const ProceduralInstruction& other) {
        return other.op == instruction.op && other.filtered && &other > &instruction && other.f == instruction.f &&
               other.i == instruction.i;
      });
      instruction.mean = same != others.end() ? same->mean : mean_of_worley(instruction);
    }
    break;
  default: break;
  }
}

} // namespace

ProceduralEmitter::ProceduralEmitter() { program_.constants.push_back(Float4{0.0f, 0.0f, 0.0f, 0.0f}); }

int16_t ProceduralEmitter::constant(const Float4& value) {
  for (size_t k = 0; k < program_.constants.size(); ++k)
    if (std::memcmp(&program_.constants[k], &value, sizeof value) == 0) return static_cast<int16_t>(~k);
  program_.constants.push_back(value);
  return static_cast<int16_t>(~(program_.constants.size() - 1));
}

int16_t ProceduralEmitter::stream(ProceduralStream stream) {
  auto found = std::find(streams_.begin(), streams_.end(), stream);
  if (found == streams_.end()) found = streams_.insert(streams_.end(), stream);
  return emit(Op::stream, {}, {.i = {static_cast<int>(found - streams_.begin())}});
}

int16_t ProceduralEmitter::emit(Op op, std::initializer_list<int16_t> operands, const Details& details) {
  std::array<int16_t, 4> list = {~0, ~0, ~0, ~0}; // constant 0
  std::copy(operands.begin(), operands.end(), list.begin());
  if (const int16_t better = fused(op, list, details); better != INT16_MIN) return better;
  ProceduralInstruction instruction{.op = op, .channels = static_cast<uint8_t>(details.channels), .operands = list};
  for (size_t k = 0; k < 4; ++k) instruction.i[k] = static_cast<int16_t>(details.i[k]);
  instruction.f = details.f;
  const bool fold = op != Op::stream && op != Op::image && std::all_of(operands.begin(), operands.end(), is_constant);
  if (fold)
    return constant(run(instruction, {value_of(list[0]), value_of(list[1]), value_of(list[2]), value_of(list[3])},
                        program_.view(), {}, {}));
  dependences_.push_back(depend(instruction));
  program_.instructions.push_back(instruction);
  return static_cast<int16_t>(program_.instructions.size() - 1);
}

// Returns the result of an equivalent form that is cheaper or has a known mean; INT16_MIN if there
// is none.
int16_t ProceduralEmitter::fused(Op op, const std::array<int16_t, 4>& list, const Details& details) {
  const auto made_by = [&](int16_t operand, Op producer) {
    return operand >= 0 && program_.instructions[static_cast<size_t>(operand)].op == producer;
  };
  const auto instruction = [&](int16_t operand) { return program_.instructions[static_cast<size_t>(operand)]; };
  const auto is_all = [&](int16_t operand, float x) {
    return is_constant(operand) && value_of(operand)[0] == x && value_of(operand)[1] == x &&
           value_of(operand)[2] == x && value_of(operand)[3] == x;
  };
  switch (op) {
  case Op::add:
    if (is_all(list[0], 0.0f)) return list[1];
    [[fallthrough]];
  case Op::subtract: return is_all(list[1], 0.0f) ? list[0] : INT16_MIN;
  case Op::multiply:
    if (is_all(list[0], 1.0f)) return list[1];
    [[fallthrough]];
  case Op::divide: return is_all(list[1], 1.0f) ? list[0] : INT16_MIN;
  case Op::absolute: {
    // |c noise| = |c| |noise|
    if (details.channels != 1) return INT16_MIN;
    int16_t inner = list[0], factor = number(1.0f);
    if (made_by(inner, Op::multiply)) {
      const ProceduralInstruction product = instruction(inner);
      const bool left = is_constant(product.operands[0]);
      if (!left && !is_constant(product.operands[1])) return INT16_MIN;
      inner = product.operands[left ? 1 : 0];
      factor = number(std::abs(value_of(product.operands[left ? 0 : 1])[0]));
    }
    for (const auto& [noise, absolute] :
         {std::pair{Op::noise2d, Op::abs_noise2d}, std::pair{Op::noise3d, Op::abs_noise3d}}) {
      if (!made_by(inner, noise) || instruction(inner).i[0] != 1) continue;
      const int16_t value = emit(absolute, {instruction(inner).operands[0]}, {.channels = 1, .i = {1}});
      return emit(Op::multiply, {value, factor}, {.channels = 1});
    }
    return INT16_MIN;
  }
  case Op::greater:
  case Op::greater_equal: {
    // Stripes: a threshold on a linear function modulo a period.
    for (const size_t side : {size_t{0}, size_t{1}}) {
      const int16_t saw = list[side], threshold = list[1 - side];
      if (!is_constant(threshold) || (!made_by(saw, Op::modulo) && !made_by(saw, Op::fract))) continue;
      const ProceduralInstruction from = instruction(saw);
      float period = 1.0f;
      if (from.op == Op::modulo) {
        if (!is_constant(from.operands[1])) continue;
        period = value_of(from.operands[1])[0];
      }
      if (!(period > 0.0f) || !dependence_of(from.operands[0]).affine) continue;
      const int16_t below = emit(Op::duty, {from.operands[0]}, {.channels = 1, .f = {period, value_of(threshold)[0]}});
      return side == 1 ? emit(Op::mix, {list[2], list[3], below}, {.channels = details.channels})
                       : emit(Op::mix, {list[3], list[2], below}, {.channels = details.channels});
    }
    return INT16_MIN;
  }
  default: return INT16_MIN;
  }
}

void ProceduralEmitter::remove_dead_code(int16_t& result) {
  std::vector<bool> needed(program_.instructions.size(), false);
  if (result >= 0) needed[static_cast<size_t>(result)] = true;
  for (size_t k = needed.size(); k-- > 0;) {
    if (!needed[k]) continue;
    const ProceduralInstruction& instruction = program_.instructions[k];
    for (size_t o = 0; o < operand_count(instruction.op); ++o)
      if (instruction.operands[o] >= 0) needed[static_cast<size_t>(instruction.operands[o])] = true;
  }
  std::vector<int16_t> moved(needed.size(), 0);
  std::vector<ProceduralInstruction> live;
  std::vector<ProceduralDependence> live_dependences;
  for (size_t k = 0; k < needed.size(); ++k) {
    if (!needed[k]) continue;
    moved[k] = static_cast<int16_t>(live.size());
    ProceduralInstruction instruction = program_.instructions[k];
    for (int16_t& operand : instruction.operands)
      if (operand >= 0) operand = moved[static_cast<size_t>(operand)];
    live.push_back(instruction);
    live_dependences.push_back(dependences_[k]);
  }
  program_.instructions = std::move(live);
  dependences_ = std::move(live_dependences);
  if (result >= 0) result = moved[static_cast<size_t>(result)];
}

// A pattern is filtered analytically if its coordinates are linear in one stream and the output is
// linear in the pattern; then filtering it alone is exact. For other instructions with features the
// spatial frequency is recorded, by which ProceduralTexture::evaluate() chooses the number of
// points.
void ProceduralEmitter::mark_filters() {
  std::vector<ProceduralInstruction>& list = program_.instructions;
  std::vector<bool> linear(list.size(), true);
  program_.frequencies.assign(streams_.size(), 0.0f);
  for (size_t k = list.size(); k-- > 0;) {
    ProceduralInstruction& instruction = list[k];
    for (size_t o = 0; o < operand_count(instruction.op); ++o) {
      const int16_t operand = instruction.operands[o];
      if (operand >= 0 && !(linear[k] && is_linear_in(instruction, o))) linear[static_cast<size_t>(operand)] = false;
    }
    const ProceduralDependence at = dependence_of(instruction.operands[0]);
    const bool known = at.affine && at.stream >= 0;
    if (is_pattern(instruction) || instruction.op == Op::image) {
      if (known) {
        ProceduralFootprint footprint{.stream = at.stream};
        std::memcpy(footprint.m, at.m, sizeof footprint.m);
        instruction.footprint = static_cast<int16_t>(program_.footprints.size());
        program_.footprints.push_back(footprint);
      }
      instruction.filtered = known && linear[k] && is_pattern(instruction);
      if (instruction.filtered) set_mean(instruction, list);
    }
    if (instruction.filtered) continue;

    // The number of features for a change of the operands by 1.
    float rate = 0.0f;
    switch (instruction.op) {
    case Op::fractal2d:
    case Op::fractal3d:
      rate = std::max(1.0f, elementary::pow(std::abs(instruction.f[0]), static_cast<float>(instruction.i[1] - 1)));
      break;
    case Op::modulo:
      rate = is_constant(instruction.operands[1])
                 ? 1.0f / std::max(min_magnitude(value_of(instruction.operands[1])), 1e-6f)
                 : 1.0f;
      break;
    case Op::duty: rate = 1.0f / instruction.f[0]; break;
    case Op::sin:
    case Op::cos: rate = 0.5f * kInvPi; break;
    case Op::tan: rate = kInvPi; break;
    case Op::sign:
    case Op::floor:
    case Op::ceil:
    case Op::round:
    case Op::fract:
    case Op::greater:
    case Op::greater_equal:
    case Op::equal: rate = 1.0f; break;
    default: rate = is_pattern(instruction) ? 1.0f : 0.0f;
    }
    if (rate == 0.0f) continue;
    const size_t counted = instruction.op == Op::greater || instruction.op == Op::greater_equal ||
                                   instruction.op == Op::equal || instruction.op == Op::modulo
                               ? 2
                               : 1;
    for (size_t o = 0; o < counted; ++o) {
      const ProceduralDependence from = dependence_of(instruction.operands[o]);
      for (size_t s = 0; s < streams_.size(); ++s)
        program_.frequencies[s] = std::max(program_.frequencies[s], rate * from.gain[s]);
    }
  }
  program_.filters_itself = std::all_of(program_.frequencies.begin(), program_.frequencies.end(),
                                        [](float frequency) { return frequency == 0.0f; });
}

ProceduralProgram ProceduralEmitter::finish(int16_t result) {
  remove_dead_code(result);
  mark_filters();
  program_.result = result;
  assign_registers(program_);
  return std::move(program_);
}

} // namespace kindling
