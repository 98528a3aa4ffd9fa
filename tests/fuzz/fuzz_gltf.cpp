// Harness: glTF as JSON text, beside a folder of files that it may name.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/load_scene.h"
#include "tests/fuzz/mutators/custom_mutator.h"
#include "tests/fuzz/mutators/mutate_json.h"

using namespace kindling::fuzz;

namespace {

// Files that URIs of the seeds name.
void write_neighbors(const InputFolder& folder) {
  static constexpr unsigned char kPng[] = {
      0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48, 0x44, 0x52, 0x00,
      0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x00, 0x00, 0x00, 0x00, 0x3a, 0x7e, 0x9b, 0x55, 0x00,
      0x00, 0x00, 0x0a, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0xf8, 0x0f, 0x00, 0x01, 0x01, 0x01, 0x00,
      0x1b, 0xb6, 0xee, 0x56, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
  folder.write("a.png", std::as_bytes(std::span(kPng)));
  folder.write("a.bin", std::string_view("\0\0\0\0\0\0\200?\0\0\0\0\0\0\0\0\0\0\200?\0\0\0\0", 24));
  folder.write("a.ies", "IESNA:LM-63-2002\nTILT=NONE\n1 1000 1 2 1 1 2 0 0 0\n1 1 1\n0 90\n0\n1 0\n");
}

} // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  use_one_thread();
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
  return mutate_in_place(data, size, max_size, seed, mutate_json);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const InputFolder folder;
  static const bool once = (write_neighbors(folder), true);
  static_cast<void>(once);
  load_and_pose(folder.write("input.gltf", input_bytes(data, size)));
  return 0;
}
