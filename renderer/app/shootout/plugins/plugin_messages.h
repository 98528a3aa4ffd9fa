// Messages between a race and the process of a plugin: one request, one reply.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling::app {

// Hidden command of the program: the process of a plugin, started by a race.
inline constexpr const char* kPluginHostCommand = "plugin-host";
// Its descriptors: messages, the race (SharedRace), the answers.
inline constexpr int kMessageDescriptor = 3, kRaceDescriptor = 4, kAnswerDescriptor = 5;

enum class PluginStep : uint32_t {
  open,         // the library of the command line; the reply's text is the plugin's description
  build,        // with `threads`
  trace,        // `set` by calls of `form` and `batch_size`; answers go to the shared memory
  query,        // the nearest hit of ray `ray` of the shared memory for answers, which gets the hit
  time_singles, // of `set`; floats go to the shared memory
  release,      // destroys the accelerator
};

struct PluginRequest {
  PluginStep step = PluginStep::open;
  uint32_t threads = 1;
  uint32_t measures_memory = 0;
  uint32_t set = 0;
  uint32_t form = 0;
  uint32_t batch_size = 0;
};

inline constexpr uint64_t kUnknownBytes = ~uint64_t{0};

struct PluginReply {
  uint32_t failed = 0; // then `text` has the reason
  char text[596] = {}; // zero-terminated
  double wall_s = 0.0;
  double cpu_s = 0.0;         // of the thread while tracing, of the process while building
  double process_cpu_s = 0.0; // while tracing
  uint64_t peak_growth_bytes = kUnknownBytes;
  uint64_t huge_page_bytes = 0;
  uint64_t memory_bytes = 0;
  uint64_t node_count = 0;
  uint64_t leaf_count = 0;
  uint64_t reference_count = 0;
  uint64_t triangle_count = 0;
  uint64_t instance_count = 0;
};

} // namespace kindling::app
