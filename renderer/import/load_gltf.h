// Loads .gltf and .glb files into a Scene, with one-line errors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/base/stopwatch.h"
#include "renderer/import/files/import_limits.h"
#include "renderer/import/json/extension_support.h"
#include "renderer/scene/scene.h"

#include <filesystem>
#include <vector>

namespace kindling {

class TextureMemory;

// Durations of the steps of an import.
struct ImportTimes {
  WorkTime files;    // reading, hashing and parsing
  WorkTime meshes;   // vertices, nodes, animations and all else except images
  WorkTime tangents; // computed where a material needs them and the file has none
  WorkTime textures; // reading and decoding of images
};

struct ImportOptions {
  ImportLimits limits;
  TextureMemory* texture_memory = nullptr; // null: all decoded images stay in memory
  bool decode_textures = true;             // false: textures keep a null image (for `info`)
  bool strict = false;                     // true: refuses what is otherwise repaired with a warning
  ImportTimes* times = nullptr;            // set at the end, if not null
  // Set at the end, if not null: the files that the scene consists of, its own first.
  std::vector<std::filesystem::path>* files = nullptr;
};

// Loads a scene. Errors are of kind input_output (unreadable) or scene_invalid, in one line: file,
// JSON pointer, value, expected values. Warnings (skipped primitives, unreadable textures,
// unsupported optional extensions, repaired faults: one for each kind, with a count) go to the
// listener, which may be null. Deterministic; decodes images and buffers in parallel with TBB.
[[nodiscard]] Result<Scene> load_gltf(const std::filesystem::path& path, const ImportOptions& options,
                                      ProgressListener* listener);

} // namespace kindling
