// Compares files by identity.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/file_conflicts.h"

#include "renderer/film/write_film.h"
#include "renderer/image/output_file.h"
#include "renderer/import/load_scene.h"
#include "renderer/session/checkpoint.h"

#include <fmt/format.h>

#include <cstdlib>
#include <map>

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

constexpr const char* kOutput = "--output";
constexpr const char* kCheckpoint = "--checkpoint";

// Returns "a.exr: is the scene as well", with the other name if it differs.
Error conflict(const NamedFile& written, const NamedFile& other, std::string_view advice) {
  const std::string alias = written.file == other.file ? "" : fmt::format(", by the name '{}'", other.file.string());
  return usage_error(
      fmt::format("{}: {}: is {} as well{}; {}", written.role, written.file.string(), other.role, alias, advice));
}

} // namespace

std::vector<NamedFile> with_role(const std::string& role, std::span<const fs::path> files) {
  std::vector<NamedFile> named;
  for (const fs::path& file : files) named.push_back({role, file});
  return named;
}

std::vector<NamedFile> files_written(const RenderOptions& options, std::span<const fs::path> outputs) {
  std::vector<NamedFile> written;
  for (const fs::path& output : outputs)
    if (!is_standard_output(output)) written.push_back({kOutput, output});
  if (!options.stats_file.empty() && options.stats_file != kStandardOutput)
    written.push_back({"--stats", options.stats_file});
  if (!options.checkpoint.enabled()) return written;
  for (const fs::path& file : files_of_checkpoint(options.checkpoint.file)) written.push_back({kCheckpoint, file});
  return written;
}

std::vector<NamedFile> files_read(const RenderOptions& options) {
  std::vector<NamedFile> read;
  if (!options.scene_file.empty()) read.push_back({"the scene", options.scene_file});
  if (!options.env_file.empty()) read.push_back({"the file of --env", options.env_file});
  if (!options.camera_path.empty()) read.push_back({"the file of --camera-path", options.camera_path});
  const char* variable = std::getenv("OCIO");
  if (!options.ocio_config.empty())
    read.push_back({"the file of --ocio", options.ocio_config});
  else if (variable != nullptr && *variable != '\0')
    read.push_back({"the file of $OCIO", variable});
  return read;
}

Result<void> check_inputs_remain(std::span<const NamedFile> written, std::span<const NamedFile> read) {
  std::map<FileIdentity, const NamedFile*> inputs;
  for (const NamedFile& input : read) inputs.emplace(FileIdentity(input.file), &input);
  for (const NamedFile& output : written)
    if (const auto found = inputs.find(FileIdentity(output.file)); found != inputs.end())
      return conflict(output, *found->second, "it would be overwritten: use another name");
  return {};
}

Result<void> check_scenes_remain(std::span<const NamedFile> written, std::vector<NamedFile> read,
                                 std::span<const fs::path> scenes, const WorldSettings& settings) {
  for (const NamedFile& scene : with_role("the scene", scenes)) read.push_back(scene);
  if (Result<void> remain = check_inputs_remain(written, read); !remain.ok()) return remain;
  for (const fs::path& scene : scenes) {
    const Result<std::vector<fs::path>> files = list_scene_files(scene, {.follow_links = settings.follow_links});
    if (!files.ok()) return files.error();
    if (Result<void> remain = check_inputs_remain(written, with_role(kSceneFile, files.value())); !remain.ok())
      return remain;
  }
  return {};
}

Result<void> check_outputs_differ(std::span<const NamedFile> written) {
  std::map<FileIdentity, const NamedFile*> outputs;
  for (const NamedFile& output : written) {
    const auto [found, is_new] = outputs.emplace(FileIdentity(output.file), &output);
    if (is_new) continue;
    const NamedFile& other = *found->second;
    const bool sums = other.role == kOutput && other.file.extension() == kAccumulationExtension;
    // A process that is killed in a save may leave two names of one generation.
    if (output.role == kCheckpoint && other.role == kCheckpoint) continue;
    if (output.role == kCheckpoint && sums && output.file.extension() == kAccumulationExtension) continue;
    if (output.role == other.role && output.file.lexically_normal() == other.file.lexically_normal())
      return usage_error(fmt::format("{}: {}: given twice", output.role, output.file.string()));
    return conflict(output, {fmt::format("a file of {}", other.role), other.file}, "use another name");
  }
  return {};
}

} // namespace kindling::app
