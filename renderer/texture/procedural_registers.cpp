// Assigns registers to the results of a procedural program.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/procedural_registers.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstdint>
#include <vector>

namespace kindling {

size_t operand_count(ProceduralOp op) {
  using Op = ProceduralOp;
  switch (op) {
  case Op::stream: return 0;
  case Op::add:
  case Op::subtract:
  case Op::multiply:
  case Op::divide:
  case Op::modulo:
  case Op::power:
  case Op::atan2:
  case Op::min:
  case Op::max:
  case Op::dot:
  case Op::cross: return 2;
  case Op::mix:
  case Op::smoothstep: return 3;
  case Op::greater:
  case Op::greater_equal:
  case Op::equal:
  case Op::swizzle: return 4;
  default: return 1;
  }
}

namespace {

// Returns true if the instruction reads that operand. A swizzle may leave some unused.
bool reads(const ProceduralInstruction& instruction, size_t operand) {
  if (operand >= operand_count(instruction.op)) return false;
  if (instruction.op != ProceduralOp::swizzle) return true;
  return std::any_of(instruction.i.begin(), instruction.i.end(),
                     [&](int16_t channel) { return static_cast<size_t>(channel >> 2) == operand; });
}

// Returns the instructions whose results an instruction reads.
std::vector<size_t> sources_of(const ProceduralInstruction& instruction) {
  std::vector<size_t> sources;
  for (size_t o = 0; o < instruction.operands.size(); ++o)
    if (instruction.operands[o] >= 0 && reads(instruction, o))
      sources.push_back(static_cast<size_t>(instruction.operands[o]));
  std::sort(sources.begin(), sources.end());
  sources.erase(std::unique(sources.begin(), sources.end()), sources.end());
  return sources;
}

// Returns the instructions that the result needs, each after its sources. Of these the one that
// needs most registers comes first (Sethi and Ullman 1970, "The Generation of Optimal Code for
// Arithmetic Expressions"), as if nothing were shared.
std::vector<size_t> order_of(const std::vector<ProceduralInstruction>& instructions, size_t result) {
  std::vector<std::vector<size_t>> sources(instructions.size());
  std::vector<size_t> need(instructions.size(), 1);
  for (size_t k = 0; k < instructions.size(); ++k) {
    sources[k] = sources_of(instructions[k]);
    std::stable_sort(sources[k].begin(), sources[k].end(), [&](size_t a, size_t b) { return need[a] > need[b]; });
    for (size_t i = 0; i < sources[k].size(); ++i) need[k] = std::max(need[k], need[sources[k][i]] + i);
  }
  struct Visit {
    size_t instruction;
    size_t next = 0; // of its sources
  };
  std::vector<size_t> order;
  std::vector<bool> visited(instructions.size(), false);
  std::vector<Visit> path{{result}};
  visited[result] = true;
  while (!path.empty()) {
    Visit& visit = path.back();
    if (visit.next == sources[visit.instruction].size()) {
      order.push_back(visit.instruction);
      path.pop_back();
      continue;
    }
    const size_t source = sources[visit.instruction][visit.next++];
    if (visited[source]) continue;
    visited[source] = true;
    path.push_back({source});
  }
  return order;
}

} // namespace

void assign_registers(ProceduralProgram& program) {
  program.register_count = 0;
  if (program.result < 0) { // a constant
    program.instructions.clear();
    return;
  }
  const std::vector<ProceduralInstruction> old = std::move(program.instructions);
  const std::vector<size_t> order = order_of(old, static_cast<size_t>(program.result));
  std::vector<size_t> last_use(old.size(), 0); // place in the order
  for (size_t place = 0; place < order.size(); ++place)
    for (const size_t source : sources_of(old[order[place]])) last_use[source] = place;

  std::vector<int16_t> register_of(old.size(), 0);
  std::vector<int16_t> free;
  program.instructions.clear();
  for (size_t place = 0; place < order.size(); ++place) {
    ProceduralInstruction instruction = old[order[place]];
    for (size_t o = 0; o < instruction.operands.size(); ++o) {
      int16_t& operand = instruction.operands[o];
      if (operand >= 0) operand = reads(instruction, o) ? register_of[static_cast<size_t>(operand)] : int16_t{0};
    }
    for (const size_t source : sources_of(old[order[place]]))
      if (last_use[source] == place) free.push_back(register_of[source]);
    if (free.empty()) free.push_back(program.register_count++);
    instruction.target = register_of[order[place]] = free.back();
    free.pop_back();
    program.instructions.push_back(instruction);
  }
  program.result = register_of[static_cast<size_t>(program.result)];
}

} // namespace kindling
