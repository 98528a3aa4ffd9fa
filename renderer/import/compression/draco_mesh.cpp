// Adapter of libdraco: header checks, decoding, conversion of attributes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/compression/draco_mesh.h"

#include "renderer/import/document/triangles.h"
#include "renderer/import/json/extensions.h"

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>
#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <atomic>
#include <cstring>
#include <exception>

namespace kindling::gltf {
namespace {

using nlohmann::json;

constexpr uint32_t kDracoGrain = 1U << 14;

// Little-endian reader of the header; ok() is false after a read past the end.
class HeaderReader {
 public:
  explicit HeaderReader(Bytes bytes) : left_(bytes) {}

  uint8_t byte() {
    if (left_.empty()) {
      ok_ = false;
      return 0;
    }
    const auto value = std::to_integer<uint8_t>(left_.front());
    left_ = left_.subspan(1);
    return value;
  }
  uint64_t varint() {
    uint64_t value = 0;
    for (int shift = 0; shift < 35; shift += 7) {
      const uint8_t part = byte();
      value |= static_cast<uint64_t>(part & 0x7fU) << shift;
      if ((part & 0x80U) == 0) return value;
    }
    ok_ = false;
    return 0;
  }
  void skip(uint64_t count) {
    if (count > left_.size()) {
      ok_ = false;
      left_ = {};
    } else {
      left_ = left_.subspan(count);
    }
  }
  [[nodiscard]] bool ok() const { return ok_; }

 private:
  Bytes left_;
  bool ok_ = true;
};

// Skips the metadata between header and counts, present if a flag is set.
void skip_metadata(HeaderReader& reader, int depth, bool& too_deep) {
  if (depth > 16) {
    too_deep = true;
    return;
  }
  const uint64_t entries = reader.varint();
  for (uint64_t i = 0; i < entries && reader.ok(); ++i) {
    reader.skip(reader.byte());
    reader.skip(reader.varint());
  }
  const uint64_t children = reader.varint();
  for (uint64_t i = 0; i < children && reader.ok() && !too_deep; ++i) {
    reader.skip(reader.byte());
    skip_metadata(reader, depth + 1, too_deep);
  }
}

Bytes compressed_bytes(const Document& document, const json& draco, const std::string& pointer) {
  const auto view = draco["bufferView"].get<size_t>();
  const Bytes bytes = document.views[view].bytes;
  if (bytes.empty()) fail(pointer + "/bufferView", fmt::format("bufferView {} has no data", view));
  return bytes;
}

template <typename T>
bool convert(const draco::PointAttribute& attribute, uint32_t points, int components, std::byte* out) {
  const size_t bytes = sizeof(T) * static_cast<size_t>(components);
  std::atomic<bool> fits{true};
  tbb::parallel_for(tbb::blocked_range<uint32_t>(0, points, kDracoGrain),
                    [&](const tbb::blocked_range<uint32_t>& range) {
                      T values[16] = {};
                      for (uint32_t i = range.begin(); i < range.end(); ++i) {
                        const draco::AttributeValueIndex index = attribute.mapped_index(draco::PointIndex(i));
                        if (index.value() >= attribute.size() ||
                            !attribute.ConvertValue<T>(index, static_cast<int8_t>(components), values)) {
                          fits.store(false, std::memory_order_relaxed);
                          return;
                        }
                        std::memcpy(out + i * bytes, values, bytes);
                      }
                    });
  return fits.load();
}

bool convert(const draco::PointAttribute& attribute, uint32_t points, const AccessorView& view, std::byte* out) {
  if (!attribute.is_mapping_identity() && attribute.indices_map_size() < points) return false;
  switch (view.component_type) {
  case TINYGLTF_COMPONENT_TYPE_BYTE: return convert<int8_t>(attribute, points, view.components, out);
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE: return convert<uint8_t>(attribute, points, view.components, out);
  case TINYGLTF_COMPONENT_TYPE_SHORT: return convert<int16_t>(attribute, points, view.components, out);
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT: return convert<uint16_t>(attribute, points, view.components, out);
  case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT: return convert<uint32_t>(attribute, points, view.components, out);
  default: return convert<float>(attribute, points, view.components, out);
  }
}

std::unique_ptr<draco::Mesh> decode_draco(Bytes bytes, const std::string& pointer) {
  draco::DecoderBuffer buffer;
  buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  std::string what;
  try {
    draco::Decoder decoder;
    auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
    if (decoded.ok() && decoded.value() != nullptr) return std::move(decoded).value();
    what = decoded.status().error_msg_string();
  } catch (const std::exception& e) {
    what = e.what();
  }
  fail(pointer, fmt::format("{} bytes that draco cannot decode: {}", bytes.size(), in_quotes(what)));
}

} // namespace

const json* find_draco(const Document& document, size_t mesh, size_t primitive) {
  return find_extension((*document.json)["meshes"][mesh]["primitives"][primitive], "KHR_draco_mesh_compression");
}

DracoCounts declared_draco_counts(const Document& document, const json& draco, const std::string& pointer) {
  const Bytes bytes = compressed_bytes(document, draco, pointer);
  if (bytes.size() < 11 || std::memcmp(bytes.data(), "DRACO", 5) != 0) fail(pointer, "not Draco data");
  HeaderReader reader(bytes.subspan(5));
  const int major = reader.byte();
  const int minor = reader.byte();
  const int type = reader.byte();
  const int method = reader.byte();
  reader.byte();
  const bool metadata = (reader.byte() & 0x80U) != 0;
  if (major != 2 || minor != 2) fail(pointer, fmt::format("Draco bitstream {}.{}, expected 2.2", major, minor));
  if (type != 1 || method > 1) fail(pointer, "Draco data that are not a mesh");
  if (metadata) {
    bool too_deep = false;
    const uint64_t count = reader.varint();
    for (uint64_t i = 0; i < count && reader.ok() && !too_deep; ++i) {
      reader.varint();
      skip_metadata(reader, 0, too_deep);
    }
    skip_metadata(reader, 0, too_deep);
    if (too_deep) fail(pointer, "Draco metadata nested more than 16 deep");
  }
  DracoCounts counts;
  if (method == 0) { // sequential
    counts.faces = reader.varint();
    counts.vertices = reader.varint();
  } else { // edgebreaker
    reader.byte();
    counts.vertices = reader.varint();
    counts.faces = reader.varint();
  }
  if (!reader.ok()) fail(pointer, "truncated Draco header");
  return counts;
}

DracoPrimitive decode_draco(const Document& document, const json& draco, const tinygltf::Primitive& primitive,
                            const std::string& pointer) {
  const std::unique_ptr<draco::Mesh> mesh = decode_draco(compressed_bytes(document, draco, pointer), pointer);
  DracoPrimitive result;
  result.vertex_count = mesh->num_points();
  result.indices.resize(size_t{mesh->num_faces()} * 3);
  tbb::parallel_for(tbb::blocked_range<uint32_t>(0, mesh->num_faces(), kDracoGrain),
                    [&](const tbb::blocked_range<uint32_t>& range) {
                      for (uint32_t i = range.begin(); i < range.end(); ++i) {
                        const draco::Mesh::Face& face = mesh->face(draco::FaceIndex(i));
                        for (size_t c = 0; c < 3; ++c) result.indices[size_t{i} * 3 + c] = face[c].value();
                      }
                    });
  if (const std::optional<size_t> bad = first_out_of_bounds(result.indices, result.vertex_count)) {
    fail(pointer,
         fmt::format("decoded index {} of triangle {}, there are {} vertices", result.indices[*bad], *bad / 3,
                     result.vertex_count),
         "ACCESSOR_INDEX_OOB");
  }
  for (const auto& [semantic, id] : draco["attributes"].items()) {
    const std::string place = fmt::format("{}/attributes/{}", pointer, semantic);
    const auto accessor = primitive.attributes.find(semantic);
    if (accessor == primitive.attributes.end()) {
      fail(place, "an attribute that the primitive does not list");
    }
    if (!id.is_number_integer() || id.get<int64_t>() < 0 || id.get<int64_t>() > UINT32_MAX) {
      fail(place, "not an id, expected an integer from 0", "TYPE_MISMATCH");
    }
    const draco::PointAttribute* attribute = mesh->GetAttributeByUniqueId(id.get<uint32_t>());
    if (attribute == nullptr) fail(place, fmt::format("id {} is not in the Draco data", id.get<uint32_t>()));
    // Draco reads any stored byte as a bool.
    if (attribute->data_type() == draco::DT_BOOL)
      fail(place, "Draco values of type bool, expected a component type of glTF");
    const tinygltf::Accessor& core = document.core.accessors[static_cast<size_t>(accessor->second)];
    DracoAttribute decoded;
    decoded.semantic = semantic;
    decoded.view.component_type = core.componentType;
    decoded.view.normalized = core.normalized;
    decoded.view.components = tinygltf::GetNumComponentsInType(static_cast<uint32_t>(core.type));
    decoded.view.count = result.vertex_count;
    decoded.view.stride = component_bytes(core.componentType) * static_cast<size_t>(decoded.view.components);
    if (attribute->num_components() != decoded.view.components) {
      fail(place, fmt::format("{} components in the Draco data, {} in accessor {}", attribute->num_components(),
                              decoded.view.components, accessor->second));
    }
    decoded.bytes = OwnedBytes(decoded.view.stride * decoded.view.count);
    if (!convert(*attribute, result.vertex_count, decoded.view, decoded.bytes.data())) {
      fail(place, fmt::format("Draco values that do not fit the component type of accessor {}", accessor->second));
    }
    decoded.view.data = decoded.bytes.data();
    result.attributes.push_back(std::move(decoded));
  }
  return result;
}

} // namespace kindling::gltf
