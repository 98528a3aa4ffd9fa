// Adapter of libmeshoptimizer; version 1 of the attribute codec goes to meshopt_attributes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/compression/meshopt_views.h"

#include "renderer/import/compression/meshopt_attributes.h"
#include "renderer/import/document/accessor.h"
#include "renderer/import/json/extensions.h"

#include <fmt/format.h>
#include <meshoptimizer.h>
#include <nlohmann/json.hpp>
#include <tbb/parallel_for.h>

#include <optional>

namespace kindling::gltf {
namespace {

using nlohmann::json;

// KHR_meshopt_compression adds version 1 of attributes and a color filter; it wins where a view has
// both.
constexpr const char* kNames[] = {"KHR_meshopt_compression", "EXT_meshopt_compression"};

struct CompressedView {
  size_t view = 0;
  std::string pointer;
  Bytes bytes;
  size_t count = 0;
  size_t stride = 0;
  std::string mode;
  std::string filter;
  OwnedBytes decoded;
  bool failed = false;
};

// Checks the conditions that libmeshoptimizer asserts: KHR_meshopt_compression, "JSON schema
// updates".
void check_stride(const CompressedView& view) {
  const auto refuse = [&](std::string_view accepted) {
    fail(view.pointer + "/byteStride",
         fmt::format("{} with mode {} and filter {}, expected {}", view.stride, view.mode, view.filter, accepted));
  };
  if (view.mode == "ATTRIBUTES") {
    if (view.stride % 4 != 0) refuse("a multiple of 4");
    if ((view.filter == "OCTAHEDRAL" || view.filter == "COLOR") && view.stride != 4 && view.stride != 8)
      refuse("4 or 8");
    if (view.filter == "QUATERNION" && view.stride != 8) refuse("8");
    return;
  }
  if (view.stride != 2 && view.stride != 4) refuse("2 or 4");
  if (view.filter != "NONE") {
    fail(view.pointer + "/filter", fmt::format("{} with mode {}, expected NONE", view.filter, view.mode));
  }
  if (view.mode == "TRIANGLES" && view.count % 3 != 0) {
    fail(view.pointer + "/count", fmt::format("{}, expected a multiple of 3", view.count));
  }
}

std::optional<CompressedView> find_compressed(const Document& document, size_t index, ElementBudget& budget) {
  const json& view_json = (*document.json)["bufferViews"][index];
  const json* extension = find_meshopt_extension(view_json);
  if (extension == nullptr) return std::nullopt;
  CompressedView view;
  view.view = index;
  const bool khr = extension == find_extension(view_json, kNames[0]);
  view.pointer = fmt::format("/bufferViews/{}/extensions/{}", index, kNames[khr ? 0 : 1]);
  view.count = (*extension)["count"].get<size_t>();
  view.stride = (*extension)["byteStride"].get<size_t>();
  view.mode = (*extension)["mode"].get<std::string>();
  view.filter = extension->value("filter", "NONE");
  check_stride(view);

  const auto buffer = (*extension)["buffer"].get<size_t>();
  const auto offset = static_cast<size_t>(integer_or(*extension, "byteOffset", 0));
  const auto length = (*extension)["byteLength"].get<size_t>();
  const Bytes bytes = document.buffers[buffer];
  if (offset > bytes.size() || length > bytes.size() - offset) {
    fail(view.pointer,
         fmt::format("bytes {} to {} of buffer {}, which has {}", offset, offset + length, buffer, bytes.size()),
         "BUFFER_VIEW_TOO_LONG");
  }
  view.bytes = bytes.subspan(offset, length);

  const size_t declared = view_json["byteLength"].get<size_t>();
  if (view.count > declared || view.count * view.stride != declared) {
    fail(view.pointer + "/count",
         fmt::format("{} elements of {} bytes, the bufferView has {} bytes", view.count, view.stride, declared));
  }
  budget.charge(declared / 4, view.pointer);
  return view;
}

bool decode_view(CompressedView& view) {
  // OwnedBytes uses operator new[], aligned for the 16-byte moves of the filters.
  view.decoded = OwnedBytes(view.count * view.stride);
  void* out = view.decoded.data();
  const auto* in = reinterpret_cast<const unsigned char*>(view.bytes.data());
  if (view.mode == "TRIANGLES")
    return meshopt_decodeIndexBuffer(out, view.count, view.stride, in, view.bytes.size()) == 0;
  if (view.mode == "INDICES")
    return meshopt_decodeIndexSequence(out, view.count, view.stride, in, view.bytes.size()) == 0;
  if (is_meshopt_attributes_v1(view.bytes)) {
    if (!decode_meshopt_attributes_v1(view.bytes, view.count, view.stride,
                                      std::span(view.decoded.data(), view.decoded.size())))
      return false;
  } else if (meshopt_decodeVertexBuffer(out, view.count, view.stride, in, view.bytes.size()) != 0) {
    return false;
  }
  if (view.filter == "COLOR") decode_meshopt_color(std::span(view.decoded.data(), view.decoded.size()), view.stride);
  if (view.filter == "OCTAHEDRAL") meshopt_decodeFilterOct(out, view.count, view.stride);
  if (view.filter == "QUATERNION") meshopt_decodeFilterQuat(out, view.count, view.stride);
  if (view.filter == "EXPONENTIAL") meshopt_decodeFilterExp(out, view.count, view.stride);
  return true;
}

} // namespace

const json* find_meshopt_extension(const json& object) {
  const json* newer = find_extension(object, kNames[0]);
  return newer != nullptr ? newer : find_extension(object, kNames[1]);
}

void decompress_meshopt_views(Document& document) {
  ElementBudget budget(document);
  std::vector<CompressedView> compressed;
  for (size_t i = 0; i < document.views.size(); ++i) {
    if (auto view = find_compressed(document, i, budget)) compressed.push_back(std::move(*view));
  }
  tbb::parallel_for(size_t{0}, compressed.size(),
                    [&](size_t i) { compressed[i].failed = !decode_view(compressed[i]); });
  for (CompressedView& view : compressed) {
    if (view.failed)
      fail(view.pointer, fmt::format("{} bytes that meshoptimizer cannot decode as {}", view.bytes.size(), view.mode));
    document.storage.push_back(std::move(view.decoded));
    document.views[view.view].bytes = document.storage.back().span();
  }
}

} // namespace kindling::gltf
