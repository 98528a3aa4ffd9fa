// Reads .gltf and .glb files into a Scene: parsed, validated once, decoded, with one-line errors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/base/stopwatch.h"
#include "renderer/scene/scene.h"

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Above these a file is refused: what a crafted file could make us allocate.
struct ImportLimits {
  uint64_t max_file_bytes = 16ULL << 30;    // of one .gltf, .glb, buffer or image
  uint64_t max_json_bytes = 512ULL << 20;   // of the JSON text; its tree takes up to 30 times as much memory
  uint64_t max_total_elements = 1ULL << 31; // accessor elements decoded, all together (also bounds decompression)
  // A small file decodes to no more than this, a larger one to no more elements than elements_per_byte times its bytes.
  uint64_t max_elements_of_small_file = 1ULL << 24;
  uint64_t elements_per_byte = 256;
  uint64_t max_texture_bytes = 64ULL << 30; // decoded images, all together
  uint32_t max_nodes = 1U << 24;
  uint32_t max_node_depth = 1024; // levels of the node tree
  uint64_t max_gpu_instances = 1ULL << 26;
};

class TextureMemory;

// What the steps of an import took.
struct ImportTimes {
  WorkTime files;    // read, hashed and parsed
  WorkTime meshes;   // vertices decoded and checked; nodes, animations and all else that is no image
  WorkTime tangents; // made where a material needs them and the file has none
  WorkTime textures; // images read and decoded
};

struct ImportOptions {
  ImportLimits limits;
  TextureMemory* texture_memory = nullptr; // null: all decoded images stay in memory
  bool decode_textures = true;             // false: textures keep a null image (for `info`)
  ImportTimes* times = nullptr;            // set at the end, if not null
};

// Errors are of kind input_output (cannot be read) or scene_invalid, one line: file, JSON pointer, what was found, what
// would be accepted. Warnings (skipped points and lines, unreadable textures, unsupported optional extensions) go to
// the listener, which may be null. Deterministic; decodes images and buffers in parallel with TBB.
[[nodiscard]] Result<Scene> load_gltf(const std::filesystem::path& path, const ImportOptions& options,
                                      ProgressListener* listener);

// Support for one extension of glTF: the one table for errors, documents, tests and `info --list-extensions`.
struct ExtensionSupport {
  std::string_view name;
  enum class Level : uint8_t { full, partial, ignored } level = Level::full; // ignored: known, has no effect yet, warns
  std::string_view note;
};
[[nodiscard]] std::vector<ExtensionSupport> supported_extensions();    // by name
[[nodiscard]] std::string_view name_of(ExtensionSupport::Level level); // full, partial, ignored
// As Markdown, the table of the README.
[[nodiscard]] std::string extension_table_markdown();

} // namespace kindling
