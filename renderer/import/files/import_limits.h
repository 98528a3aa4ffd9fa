// Limits on what a glTF file may ask for: sizes, and files outside of its folder.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>

namespace kindling {

// A file above one of these limits is refused. They bound the memory that a crafted file can
// allocate.
struct ImportLimits {
  uint64_t max_file_bytes = 16ULL << 30;  // size of one .gltf, .glb, buffer or image
  uint64_t max_json_bytes = 512ULL << 20; // size of the JSON text; its tree takes up to 30 times as much memory
  // The budget of a file in elements of at most 16 bytes, charged before they are allocated:
  // decoded elements of accessors, numbers of animation keys, deformed vertices of all nodes,
  // objects of the JSON text by their size in memory. Also bounds decompression.
  uint64_t max_total_elements = 1ULL << 31;
  // A file has at most max(max_elements_of_small_file, elements_per_byte times its bytes) elements.
  uint64_t max_elements_of_small_file = 1ULL << 24;
  uint64_t elements_per_byte = 64;
  uint64_t max_texture_bytes = 64ULL << 30; // sum over all decoded images
  uint32_t max_nodes = 1U << 24;
  uint32_t max_node_depth = 1024; // levels of the node tree
  uint64_t max_gpu_instances = 1ULL << 26;
  // Accepts symbolic links that lead out of the scene's folder.
  bool follow_links = false;
};

} // namespace kindling
