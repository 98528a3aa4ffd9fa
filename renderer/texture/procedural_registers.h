// The order of a procedural program's instructions, and the registers of their results.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/texture/procedural_program.h"

#include <cstddef>

namespace kindling {

// Returns the number of operands that an operation reads.
[[nodiscard]] size_t operand_count(ProceduralOp op);

// Orders the instructions so that few results are needed at a time, and replaces their numbers by
// registers. The program's operands refer to earlier instructions. Sets `register_count`, which may
// exceed kMaxProceduralRegisters.
void assign_registers(ProceduralProgram& program);

} // namespace kindling
