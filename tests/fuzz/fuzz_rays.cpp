// Harness: files of recorded rays.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/ray_file.h"
#include "tests/fuzz/fuzz_support.h"

using namespace kindling;
using namespace kindling::fuzz;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const InputFolder folder;
  const std::filesystem::path file = folder.write("input.rays", input_bytes(data, size));
  const Result<RayRecording> read = read_ray_file(file);
  if (!read) require_good_message(read.error(), file.string() + ": ");
  return 0;
}
