// Harness: PNG images.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/decode_input.h"
#include "tests/fuzz/mutators/custom_mutator.h"
#include "tests/fuzz/mutators/mutate_png.h"

using namespace kindling::fuzz;

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  use_one_thread();
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
  return mutate_in_place(data, size, max_size, seed, mutate_png);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  decode_to_the_end(input_bytes(data, size));
  return 0;
}
