// Opens a file: container, JSON, tinygltf's structs, buffers, bufferViews.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/open_document.h"

#include "renderer/import/compression/meshopt_views.h"
#include "renderer/import/document/accessor.h"
#include "renderer/import/document/scene_files.h"
#include "renderer/import/files/glb.h"
#include "renderer/import/files/number_range.h"
#include "renderer/import/files/other_formats.h"
#include "renderer/import/files/uri.h"
#include "renderer/import/files/utf8.h"
#include "renderer/import/json/check_json.h"
#include "renderer/import/json/core_structs.h"
#include "renderer/import/json/extensions.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <optional>

namespace kindling::gltf {
namespace {

using nlohmann::json;

// Returns the text without its middle if it is long: an error quotes the last word that was read,
// which may be most of a file.
std::string without_middle(const std::string& text) {
  constexpr size_t kHead = 120, kTail = 60;
  if (text.size() <= kHead + kTail) return text;
  const auto is_inside_character = [&](size_t i) { return (static_cast<unsigned char>(text[i]) & 0xc0) == 0x80; };
  size_t head = kHead, tail = text.size() - kTail;
  while (head > 0 && is_inside_character(head)) --head;
  while (tail < text.size() && is_inside_character(tail)) ++tail;
  return text.substr(0, head) + " ... " + text.substr(tail);
}

// Parses text; throws ImportFailure.
json parse(std::string_view text) {
  try {
    return json::parse(text.begin(), text.end());
  } catch (const json::exception& e) {
    // Removes the first word of "[json.exception.parse_error.101] parse error at line 1, column 2:
    // ...".
    std::string_view what = e.what();
    if (const size_t end = what.find("] "); end != std::string_view::npos) what.remove_prefix(end + 2);
    std::string line;
    for (const char c : what) line += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
    fail("", fmt::format("not valid JSON: {}", without_middle(line)), "INVALID_JSON");
  }
}

json parse_json(std::string_view text, uint64_t max_bytes, Warnings& warnings) {
  if (text.size() > max_bytes) {
    fail("", fmt::format("{} bytes of JSON, at most {} are accepted", text.size(), max_bytes));
  }
  // Some exporters pad with zero bytes, which are not JSON.
  while (!text.empty() && text.back() == '\0') text.remove_suffix(1);
  struct Remedy {
    const char* kind;
    std::string (*change)(std::string_view text);
    const char* description;
  };
  std::string readable; // owns the text once it is changed
  for (const Remedy& remedy : {Remedy{"UTF-8", replace_invalid_utf8, "bytes that are not UTF-8 are replaced"},
                               {"number range", limit_numbers, "the largest number is used"}}) {
    try {
      return parse(text);
    } catch (const ImportFailure& fault) {
      std::string changed = remedy.change(text);
      if (changed == text) continue;
      warnings.repair(remedy.kind, fault, remedy.description);
      readable = std::move(changed);
      text = readable;
    }
  }
  return parse(text);
}

// Parses "major.minor".
std::optional<std::pair<int, int>> parse_version(std::string_view text) {
  int major = 0;
  int minor = 0;
  const char* end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, major);
  if (first.ec != std::errc() || first.ptr == end || *first.ptr != '.') return std::nullopt;
  const auto second = std::from_chars(first.ptr + 1, end, minor);
  if (second.ec != std::errc() || second.ptr != end || major < 0 || minor < 0) return std::nullopt;
  return std::pair{major, minor};
}

// Exporters write 2, "2" and "2.0.1", which can mean 2.0 only.
bool means_two(const json& version) {
  if (version.is_number()) return version.get<double>() >= 2.0 && version.get<double>() < 3.0;
  const auto& text = version.get_ref<const std::string&>();
  return text == "2" || text.starts_with("2.");
}

void check_version(json& asset, const char* name, bool minimum, const std::filesystem::path& file, Warnings& warnings) {
  const auto found = asset.find(name);
  if (found == asset.end()) return;
  const std::string pointer = fmt::format("/asset/{}", name);
  const bool number = found->is_number();
  const std::string text = number ? fmt::format("{}", found->get<double>()) : found->get<std::string>();
  const auto version = parse_version(text);
  if (number || !version) {
    const std::string fault = number ? fmt::format("{}, expected a string", text)
                                     : fmt::format("{}, expected a version like 2.0", in_quotes(text));
    const char* code = number ? "TYPE_MISMATCH" : "PATTERN_MISMATCH";
    if (!means_two(*found)) fail(pointer, fault, code);
    warnings.repair("version", pointer, fault, code, "it is read as 2.0");
    *found = "2.0";
    return;
  }
  if (version->first == 1) {
    fail(pointer, fmt::format("glTF {}, expected 2.0; convert it with {}", text, converter_of_version_1(file)),
         "UNKNOWN_ASSET_MAJOR_VERSION");
  }
  const std::string fault = fmt::format("glTF {}, expected 2.0", text);
  if (version->first != 2) fail(pointer, fault, "UNKNOWN_ASSET_MAJOR_VERSION");
  if (minimum && version->second > 0)
    warnings.repair("version", pointer, fault, "UNKNOWN_ASSET_MAJOR_VERSION", "it is read as 2.0");
}

// Checks the version before all else, so that the error for another version names it.
void check_asset_first(json& root, const std::filesystem::path& file, Warnings& warnings) {
  if (!root.is_object()) return;
  const auto asset = root.find("asset");
  if (asset == root.end() || !asset->is_object()) return;
  const auto version = asset->find("version");
  if (version == asset->end() || !(version->is_string() || version->is_number())) return;
  check_version(*asset, "version", false, file, warnings);
  const auto minimum = asset->find("minVersion");
  if (minimum != asset->end() && minimum->is_string()) check_version(*asset, "minVersion", true, file, warnings);
}

// Reads all buffers. `container` is true for a .glb, whose BIN chunk is `bin`.
void read_buffers(Document& document, bool container, std::optional<Bytes> bin, Warnings& warnings) {
  json& root = *document.json;
  if (!root.contains("buffers")) return;
  json& buffers = root["buffers"];
  for (size_t i = 0; i < buffers.size(); ++i) {
    json& buffer = buffers[i];
    const std::string pointer = fmt::format("/buffers/{}", i);
    const auto length = buffer["byteLength"].get<uint64_t>();
    const json* meshopt = find_meshopt_extension(buffer);
    if (meshopt != nullptr && meshopt->value("fallback", false)) {
      document.buffers.emplace_back();
      continue;
    }
    if (length > document.limits.max_file_bytes) {
      fail(pointer + "/byteLength", fmt::format("{}, at most {} are accepted", length, document.limits.max_file_bytes));
    }
    Bytes bytes;
    if (!buffer.contains("uri")) {
      if (i == 0 && bin) {
        bytes = *bin;
      } else {
        if (i == 0 && container) {
          warnings.repair("no BIN", pointer, "no uri, and the .glb has no BIN chunk", "BUFFER_MISSING_GLB_DATA",
                          "the buffer has no data");
        }
        document.buffers.emplace_back(); // an error at its first use
        continue;
      }
    } else {
      auto& uri = buffer["uri"].get_ref<std::string&>();
      const bool data = is_data_uri(uri);
      Result<OwnedBytes> owned = Error{};
      if (data) {
        owned = decode_data_uri(uri);
        uri = "data:"; // the text is no longer needed
        uri.shrink_to_fit();
      } else {
        auto path = resolve_uri(document.path.parent_path(), uri);
        if (!path) fail(pointer + "/uri", path.error().message);
        owned = read_file(path.value(), document.limits.max_file_bytes);
        if (!owned)
          fail(pointer + "/uri", fmt::format("{} {}", in_quotes(uri), owned.error().message), "IO_ERROR",
               ErrorKind::input_output);
      }
      if (!owned) fail(pointer + "/uri", owned.error().message);
      if (!data) {
        document.content_hash = hash_content(owned.value().span(), document.content_hash);
        document.bytes_read += owned.value().size();
      }
      document.storage.push_back(std::move(owned).value());
      bytes = document.storage.back().span();
    }
    if (bytes.size() < length) {
      warnings.repair("buffer length", pointer, fmt::format("declares {} bytes but has {}", length, bytes.size()),
                      "BUFFER_BYTE_LENGTH_MISMATCH", "these are read");
    }
    document.buffers.push_back(bytes.first(std::min<uint64_t>(length, bytes.size())));
  }
}

void make_views(Document& document, Warnings& warnings) {
  const std::vector<tinygltf::BufferView>& views = document.core.bufferViews;
  for (size_t i = 0; i < views.size(); ++i) {
    const tinygltf::BufferView& view = views[i];
    const json& buffer = (*document.json)["buffers"][static_cast<size_t>(view.buffer)];
    const Bytes data = document.buffers[static_cast<size_t>(view.buffer)];
    // A buffer without data has the declared length: an error at its first use.
    const uint64_t length = data.empty() ? buffer["byteLength"].get<uint64_t>() : data.size();
    ViewBytes bytes;
    bytes.length = view.byteLength;
    bytes.stride = static_cast<size_t>(integer_or((*document.json)["bufferViews"][i], "byteStride", 0));
    if (view.byteOffset > length || view.byteLength > length - view.byteOffset) {
      warnings.repair("view length", fmt::format("/bufferViews/{}", i),
                      fmt::format("bytes {} to {} of buffer {}, which has {}", view.byteOffset,
                                  view.byteOffset + view.byteLength, view.buffer, length),
                      "BUFFER_VIEW_TOO_LONG", "it ends with the buffer");
      bytes.length = length - std::min<uint64_t>(view.byteOffset, length);
    }
    if (!data.empty() && bytes.length > 0) bytes.bytes = data.subspan(view.byteOffset, bytes.length);
    document.views.push_back(bytes);
  }
}

// Charges the structs of the file's objects before they are made. `{}` takes three bytes as text.
void charge_objects(Document& document) {
  // Elements of 16 bytes, in JSON, tinygltf's structs and ours, measured with empty objects.
  struct Objects {
    const char* name;
    uint64_t elements;
  };
  constexpr std::array kObjects = {Objects{"accessors", 64}, Objects{"animations", 64}, Objects{"bufferViews", 32},
                                   Objects{"cameras", 64},   Objects{"images", 64},     Objects{"materials", 320},
                                   Objects{"meshes", 64},    Objects{"nodes", 200},     Objects{"samplers", 32},
                                   Objects{"scenes", 64},    Objects{"skins", 64},      Objects{"textures", 64}};
  ElementBudget budget(document);
  for (const Objects& objects : kObjects) {
    const auto found = document.json->find(objects.name);
    if (found != document.json->end() && found->is_array())
      budget.charge(found->size() * objects.elements, fmt::format("/{}", objects.name));
  }
}

bool named_glb(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  for (char& c : extension) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return extension == ".glb";
}

// The file itself: checked JSON, and the BIN chunk if there is one.
struct OpenedFile {
  Document document;
  CorePlaces places;
  std::optional<Bytes> bin;
  bool container = false;
};

OpenedFile open_file(const std::filesystem::path& path, const ImportLimits& limits, Warnings& warnings) {
  OpenedFile opened;
  Document& document = opened.document;
  document.path = path;
  document.limits = limits;
  auto file = read_file(path, limits.max_file_bytes);
  if (!file) fail("", file.error().message, "", ErrorKind::input_output);
  document.bytes_read = file.value().size();
  document.content_hash = hash_content(file.value().span());

  Bytes text = file.value().span();
  opened.container = is_glb(text) || named_glb(path);
  if (opened.container) {
    const GlbChunks chunks = split_glb(text, path, warnings);
    text = chunks.json;
    opened.bin = chunks.bin;
  } else if (text.empty()) {
    fail("", "the file is empty, expected JSON or a .glb", "INVALID_JSON");
  } else if (const std::string other = describe_other_format(text, path); !other.empty()) {
    fail("", other);
  }
  document.json = std::make_unique<json>(parse_json(as_text(text), limits.max_json_bytes, warnings));
  if (opened.bin) document.storage.push_back(std::move(file).value());

  check_asset_first(*document.json, path, warnings);
  opened.places = check_json(*document.json, warnings);
  check_extensions(*document.json, warnings);
  return opened;
}

} // namespace

Document open_document(const std::filesystem::path& path, const ImportLimits& limits, Warnings& warnings) {
  OpenedFile opened = open_file(path, limits, warnings);
  Document& document = opened.document;
  charge_objects(document);
  document.core = read_core_structs(*document.json, opened.places);
  document.faulty_accessors = opened.places.faulty_accessors;
  if (document.core.nodes.size() > limits.max_nodes) {
    fail("/nodes", fmt::format("{} nodes, at most {} are accepted", document.core.nodes.size(), limits.max_nodes));
  }
  document.files = find_scene_files(document);
  read_buffers(document, opened.container, opened.bin, warnings);
  make_views(document, warnings);
  decompress_meshopt_views(document);
  check_accessors(document, warnings);
  return std::move(document);
}

std::vector<std::filesystem::path> list_files(const std::filesystem::path& path, const ImportLimits& limits) {
  Warnings ignored(false);
  return find_scene_files(open_file(path, limits, ignored).document);
}

} // namespace kindling::gltf
