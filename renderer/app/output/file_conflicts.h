// Outputs that are also inputs, or two outputs in one file: found before anything is overwritten.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/options.h"
#include "renderer/base/result.h"

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace kindling::app {

// A file and what it is for: "--env", "the scene".
struct NamedFile {
  std::string role;
  std::filesystem::path file;
};

// Roles of files that are known once they have been read.
inline constexpr const char* kSceneFile = "a file of the scene";
inline constexpr const char* kViewFile = "a file of the OpenColorIO configuration";

// The files that a command writes: outputs, --stats, --checkpoint with the files beside it. Without
// standard output.
[[nodiscard]] std::vector<NamedFile> files_written(const RenderOptions& options,
                                                   std::span<const std::filesystem::path> outputs);
// The files that the options of a command name for reading: scene, --env, --ocio.
[[nodiscard]] std::vector<NamedFile> files_read(const RenderOptions& options);
// The same role for many files.
[[nodiscard]] std::vector<NamedFile> with_role(const std::string& role, std::span<const std::filesystem::path> files);

// Fails (usage) if a written file is among the read ones, by this or another name (FileIdentity).
[[nodiscard]] Result<void> check_inputs_remain(std::span<const NamedFile> written, std::span<const NamedFile> read);
// The same for a command that reads several scenes: `read` and the files of each scene, which are
// listed without being read. Fails as list_scene_files() does, too.
[[nodiscard]] Result<void> check_scenes_remain(std::span<const NamedFile> written, std::vector<NamedFile> read,
                                               std::span<const std::filesystem::path> scenes,
                                               const WorldSettings& settings);
// Fails (usage) if two written files are one. An output may be the checkpoint itself, which holds
// the same sums, and the generations of a checkpoint may be one file, as a killed save leaves them.
[[nodiscard]] Result<void> check_outputs_differ(std::span<const NamedFile> written);

} // namespace kindling::app
