// Harness: photometric profiles of luminaires (IES LM-63).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/lights/parse_ies.h"
#include "tests/fuzz/fuzz_support.h"

using namespace kindling;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const Result<Photometry> profile = gltf::parse_ies(fuzz::input_text(data, size));
  if (!profile) fuzz::require_good_message(profile.error(), "line ");
  return 0;
}
