// Reads .gltf and .glb files into a Scene: parsed, validated once, decoded, with one-line errors.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/base/stopwatch.h"
#include "renderer/import/files/import_limits.h"
#include "renderer/import/json/extension_support.h"
#include "renderer/scene/scene.h"

#include <filesystem>

namespace kindling {

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

} // namespace kindling
