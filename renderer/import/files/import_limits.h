// The sizes above which a file is refused.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling {

// Above these a file is refused: what a crafted file could make us allocate.
struct ImportLimits {
  uint64_t max_file_bytes = 16ULL << 30;    // of one .gltf, .glb, buffer or image
  uint64_t max_json_bytes = 512ULL << 20;   // of the JSON text; its tree takes up to 30 times as much memory
  uint64_t max_total_elements = 1ULL << 31; // accessor elements decoded, all together (also bounds decompression)
  // A small file decodes to no more than this, a larger one to no more elements than elements_per_byte times its bytes.
  uint64_t max_elements_of_small_file = 1ULL << 24;
  uint64_t elements_per_byte = 256;
  uint64_t max_texture_bytes = 64ULL << 30; // decoded images, all together
  uint32_t max_nodes = 1U << 24;
  uint32_t max_node_depth = 1024; // levels of the node tree
  uint64_t max_gpu_instances = 1ULL << 26;
};

} // namespace kindling
