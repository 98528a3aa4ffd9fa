// Harness: glTF in its binary container.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/load_scene.h"
#include "tests/fuzz/mutators/custom_mutator.h"
#include "tests/fuzz/mutators/mutate_glb.h"

using namespace kindling::fuzz;

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  use_one_thread();
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
  return mutate_in_place(data, size, max_size, seed, mutate_glb);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const InputFolder folder;
  load_and_pose(folder.write("input.glb", input_bytes(data, size)));
  return 0;
}
