// Counts what threads executed, and what a warp of them would issue.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "tests/device/ptx/machine.h"

#include <string>

namespace ptx {

inline constexpr u32 kWarp = 32;

struct Count {
  u64 launches = 0, threads = 0;
  u64 instructions = 0; // of threads
  u64 issued = 0;       // of warps: by issued_by_warp()
  Traffic traffic;
};

// Returns the instructions that a warp issues for threads that took these steps. Threads that part
// at a branch take their ways one after the other, and wait for each other at its immediate
// post-dominator, where NVIDIA's compilers put barriers of convergence since Volta (W. Fung et al.,
// "Dynamic warp formation and scheduling for efficient GPU control flow", MICRO 2007).
[[nodiscard]] u64 issued_by_warp(const std::vector<std::vector<Step>>& threads);

// Adds to the counts of kernel `name`; any thread may call it. At the end of the process they are
// appended to the file that PTX_COUNTS in the environment names, a line for each kernel: its name,
// launches, threads, instructions, issued, and bytes: global loaded, stored, local loaded, stored.
void add_count(const std::string& name, const Count& count);

} // namespace ptx
