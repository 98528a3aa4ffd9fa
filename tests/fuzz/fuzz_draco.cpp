// Harness: a primitive compressed by Draco, in a glTF file made for it.
//
// The first byte chooses component types; the others are the Draco data.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/load_scene.h"

#include <fmt/format.h>

#include <string>

using namespace kindling::fuzz;

namespace {

// Returns a .glb whose BIN chunk is the data. Attributes 0 to 3 of the data are positions, normals,
// texture coordinates and joints or colors.
std::string file_of(uint8_t choices, std::string_view data) {
  const bool colors = (choices & 1U) != 0;
  const char* fourth = colors ? "COLOR_0" : "JOINTS_0";
  const int component = (choices & 2U) != 0 ? 5121 : 5123;
  // Fewer attributes in some files, since data with too few are refused.
  const unsigned attributes = 1U + (choices >> 2U & 3U);
  std::string ids = R"("POSITION":0)", accessors = ids;
  if (attributes > 1) ids += R"(,"NORMAL":1)";
  if (attributes > 2) ids += R"(,"TEXCOORD_0":2)";
  if (attributes > 3) ids += fmt::format(R"(,"{}":3)", fourth);
  accessors = ids; // accessors have the numbers of the attributes
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["KHR_draco_mesh_compression"],)"
      R"("extensionsRequired":["KHR_draco_mesh_compression"],"buffers":[{{"byteLength":{0}}}],)"
      R"("bufferViews":[{{"buffer":0,"byteLength":{0}}}],"accessors":[)"
      R"({{"componentType":5126,"count":3,"type":"VEC3"}},{{"componentType":5126,"count":3,"type":"VEC3"}},)"
      R"({{"componentType":5126,"count":3,"type":"VEC2"}},)"
      R"({{"componentType":{1},"count":3,"type":"VEC4"{2}}},)"
      R"({{"componentType":5125,"count":3,"type":"SCALAR"}}],)"
      R"("meshes":[{{"primitives":[{{"attributes":{{{3}}},"indices":4,"extensions":)"
      R"({{"KHR_draco_mesh_compression":{{"bufferView":0,"attributes":{{{4}}}}}}}}}]}}],)"
      R"("nodes":[{{"mesh":0}}],"scenes":[{{"nodes":[0]}}]}})",
      data.size(), component, colors ? R"(,"normalized":true)" : "", accessors, ids);
  return make_glb(std::move(json), data);
}

} // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  use_one_thread();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const InputFolder folder;
  if (size < 2) return -1;
  load_and_pose(folder.write("input.glb", file_of(data[0], input_text(data, size).substr(1))));
  return 0;
}
