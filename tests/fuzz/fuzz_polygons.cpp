// Harness: meshes in .ply, .obj and .stl files; the first byte chooses the format.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/polygons/read_obj.h"
#include "renderer/import/polygons/read_ply.h"
#include "renderer/import/polygons/read_stl.h"
#include "tests/fuzz/fuzz_support.h"

#include <cstdlib>

using namespace kindling;

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  if (size == 0) return 0;
  const gltf::Bytes file = std::as_bytes(std::span(data + 1, size - 1));
  ImportLimits limits;
  limits.max_total_elements = 1 << 18;
  gltf::Warnings warnings;
  polygons::PolygonBuilder builder(limits, warnings);
  try {
    switch (data[0] % 3) {
    case 0: polygons::read_ply(file, builder); break;
    case 1: polygons::read_obj(file, warnings, builder); break;
    default: polygons::read_stl(file, builder); break;
    }
    const Primitive primitive = builder.finish();
    for (const uint32_t index : primitive.indices)
      if (index >= primitive.positions.size()) std::abort();
    if (!primitive.normals.empty() && primitive.normals.size() != primitive.positions.size()) std::abort();
  } catch (const gltf::ImportFailure& failure) {
    fuzz::require_good_message(failure.error, "");
  }
  return 0;
}
