// Harness: WebP images.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/decode_input.h"

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  kindling::fuzz::use_one_thread();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  kindling::fuzz::decode_to_the_end(kindling::fuzz::input_bytes(data, size));
  return 0;
}
