// Emitter of procedural instructions, which tracks the dependence of each value on the streams.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/procedural_program.h"
#include "renderer/texture/procedural_texture.h"

#include <array>
#include <cassert>
#include <vector>

namespace kindling {

// The dependence of a value on the streams.
struct ProceduralDependence {
  // True for a linear function of one stream plus a constant: channel k changes by the scalar
  // product of m[k] with the change of the stream.
  bool affine = false;
  int stream = -1; // -1 for constants
  float m[4][3] = {};
  // For each stream, the estimated change of the value for a change of the stream by 1.
  std::array<float, kProceduralStreams> gain{};
};

// Builds a program, instruction by instruction.
class ProceduralEmitter {
 public:
  using Op = ProceduralOp;
  struct Details {
    int channels = 4; // 1 for a single number
    std::array<int, 4> i{};
    std::array<float, 2> f{};
  };

  ProceduralEmitter();

  // These functions return operands (see ProceduralInstruction).
  [[nodiscard]] int16_t constant(const Float4& value);
  [[nodiscard]] int16_t number(float value) { return constant(Float4{value, value, value, value}); }
  [[nodiscard]] int16_t stream(ProceduralStream stream);
  // Emits an instruction, unless it can be folded to a constant or replaced by an earlier result.
  [[nodiscard]] int16_t emit(Op op, std::initializer_list<int16_t> operands, const Details& details);

  [[nodiscard]] static bool is_constant(int16_t operand) { return operand < 0; }
  // Returns the value of a constant operand.
  [[nodiscard]] const Float4& value_of(int16_t operand) const {
    assert(is_constant(operand));
    return program_.constants[static_cast<size_t>(~operand)];
  }

  // Removes instructions that `result` does not need, marks filtered patterns, and returns the
  // program by move.
  [[nodiscard]] ProceduralProgram finish(int16_t result);
  [[nodiscard]] const std::vector<ProceduralStream>& streams() const { return streams_; }

 private:
  [[nodiscard]] ProceduralDependence dependence_of(int16_t operand) const;
  [[nodiscard]] ProceduralDependence depend(const ProceduralInstruction& instruction) const;
  [[nodiscard]] int16_t fused(Op op, const std::array<int16_t, 4>& operands, const Details& details);
  void remove_dead_code(int16_t& result);
  void mark_filters();

  ProceduralProgram program_;
  std::vector<ProceduralDependence> dependences_; // by instruction
  std::vector<ProceduralStream> streams_;
};

} // namespace kindling
