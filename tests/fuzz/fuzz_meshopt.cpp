// Harness: a bufferView compressed by meshoptimizer, in a glTF file made for it.
//
// The first eight bytes choose extension, mode, filter, stride and number of elements; the others
// are the stream.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/load_scene.h"

#include <fmt/format.h>

#include <array>
#include <string>

using namespace kindling::fuzz;

namespace {

constexpr size_t kChoices = 8;

template <size_t kCount>
const char* choose(const std::array<const char*, kCount>& names, uint8_t byte) {
  return names[byte % kCount];
}

// Returns a .glb whose BIN chunk is the stream. `choices` has kChoices bytes.
std::string file_of(const uint8_t* choices, std::string_view stream) {
  const char* extension = choices[0] % 2 == 0 ? "EXT_meshopt_compression" : "KHR_meshopt_compression";
  const char* mode = choose<3>({"ATTRIBUTES", "TRIANGLES", "INDICES"}, choices[1]);
  const char* filter = choose<5>({"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"}, choices[2]);
  const size_t stride = choices[3];
  const size_t count = choices[4] | size_t{choices[5]} << 8U;
  const size_t bytes = count * stride;
  // Attributes are read as positions if they can be, indices as indices.
  const bool indices = choices[1] % 3 != 0;
  std::string json = fmt::format(
      R"({{"asset":{{"version":"2.0"}},"extensionsUsed":["{0}"],"extensionsRequired":["{0}"],)"
      R"("buffers":[{{"byteLength":{1}}},{{"byteLength":{2},"extensions":{{"{0}":{{"fallback":true}}}}}}],)"
      R"("bufferViews":[{{"buffer":1,"byteLength":{2}{3},"extensions":{{"{0}":{{"buffer":0,"byteLength":{1},)"
      R"("byteStride":{4},"count":{5},"mode":"{6}","filter":"{7}"}}}}}},{{"buffer":0,"byteLength":{1}}}],)"
      R"("accessors":[{{"bufferView":{8},"componentType":5126,"count":{9},"type":"VEC3"}}{10}],)"
      R"("meshes":[{{"primitives":[{{"attributes":{{"POSITION":0}}{11}}}]}}],"nodes":[{{"mesh":0}}],)"
      R"("scenes":[{{"nodes":[0]}}]}})",
      extension, stream.size(), bytes, indices ? std::string() : fmt::format(R"(,"byteStride":{})", stride), stride,
      count, mode, filter, indices ? 1 : 0, indices ? stream.size() / 12 : count,
      indices ? fmt::format(R"(,{{"bufferView":0,"componentType":{},"count":{},"type":"SCALAR"}})",
                            stride == 2 ? 5123 : 5125, count)
              : std::string(),
      indices ? R"(,"indices":1)" : "");
  return make_glb(std::move(json), stream);
}

} // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  use_one_thread();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const InputFolder folder;
  if (size < kChoices) return -1;
  load_and_pose(folder.write("input.glb", file_of(data, input_text(data, size).substr(kChoices))));
  return 0;
}
