// Writes the instructions of a program and keeps book of how each value depends on the streams.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/procedural_program.h"
#include "renderer/texture/procedural_texture.h"

#include <array>
#include <vector>

namespace kindling {

// How a value follows from the streams.
struct ProceduralDependence {
  // A linear function of one stream, plus a constant: channel k changes by the scalar product of m[k] with the stream's change.
  bool affine = false;
  int stream = -1; // -1: of none
  float m[4][3] = {};
  // By stream, about how much it can change for a change of 1.
  std::array<float, kProceduralStreams> gain{};
};

class ProceduralEmitter {
 public:
  using Op = ProceduralOp;
  struct Details {
    int channels = 4; // 1: a single number
    std::array<int, 4> i{};
    std::array<float, 2> f{};
  };

  ProceduralEmitter();

  // Operands: see ProceduralInstruction.
  [[nodiscard]] int16_t constant(const Float4& value);
  [[nodiscard]] int16_t number(float value) { return constant(Float4{value, value, value, value}); }
  [[nodiscard]] int16_t stream(ProceduralStream stream);
  // What can be computed now, is.
  [[nodiscard]] int16_t emit(Op op, std::initializer_list<int16_t> operands, const Details& details);

  [[nodiscard]] static bool is_constant(int16_t operand) { return operand < 0; }
  [[nodiscard]] const Float4& value_of(int16_t operand) const { // of a constant
    return program_.constants[static_cast<size_t>(~operand)];
  }

  // Leaves out what `result` does not need, marks filters, and gives the program away.
  [[nodiscard]] ProceduralProgram finish(int16_t result);
  [[nodiscard]] const std::vector<ProceduralStream>& streams() const { return streams_; }

 private:
  [[nodiscard]] ProceduralDependence dependence_of(int16_t operand) const;
  [[nodiscard]] ProceduralDependence depend(const ProceduralInstruction& instruction) const;
  [[nodiscard]] int16_t fused(Op op, const std::array<int16_t, 4>& operands, const Details& details);
  void leave_out_dead(int16_t& result);
  void mark_filters();

  ProceduralProgram program_;
  std::vector<ProceduralDependence> dependences_; // by instruction
  std::vector<ProceduralStream> streams_;
};

} // namespace kindling
