// The memory of a wave of the Whitted tracer.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/device/kernels/wave.h"
#include "renderer/integrator/whitted_tree.h"

#include <cstdint>

namespace kindling {

// The argument of the kernels of tree_kernels.h.
struct TreeWave : Wave {
  // By sample. Nodes of one sample may add to them at the same time.
  WhittedSample* sums = nullptr;
  WhittedComponents* components = nullptr; // null if no AOV needs it
  // Nodes to be traced, the newest last, and how many there are.
  WhittedNode* waiting = nullptr;
  uint32_t* waiting_count = nullptr;
  // Nodes of this round, taken from waiting[first_taken] on.
  WhittedNode* nodes = nullptr;
  uint32_t first_taken = 0;
};

} // namespace kindling
