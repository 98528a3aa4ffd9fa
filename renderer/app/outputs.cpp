// The files that a render writes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/outputs.h"

#include "renderer/app/text_format.h"
#include "renderer/app/version.h"
#include "renderer/image/atomic_file.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <cctype>

namespace kindling::app {

namespace fs = std::filesystem;

namespace {

bool is_exr(const fs::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension == ".exr";
}

bool wants_layers(AovSet aovs) {
  return std::any_of(kAovs.begin(), kAovs.end(), [&](const AovInfo& info) {
    return info.aov != Aov::beauty && info.aov != Aov::alpha && aovs.contains(info.aov);
  });
}

Error input_output(std::string message) { return {ErrorKind::input_output, std::move(message)}; }

} // namespace

Result<void> check_writable(const fs::path& path) {
  std::error_code ignored;
  if (fs::is_directory(path, ignored))
    return input_output(fmt::format("{}: is a folder; use the name of a file", path.string()));
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  if (!fs::exists(folder, ignored))
    return input_output(fmt::format("{}: folder '{}' does not exist; create it first", path.string(), folder.string()));
  if (!fs::is_directory(folder, ignored))
    return input_output(fmt::format("{}: '{}' is not a folder", path.string(), folder.string()));
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    return input_output(fmt::format("{}: folder '{}' cannot be written to", path.string(), folder.string()));
  return {};
}

Result<std::vector<fs::path>> choose_outputs(const RenderOptions& options) {
  std::vector<fs::path> outputs = options.outputs;
  if (outputs.empty()) outputs.push_back(options.scene_file.stem().string() + ".png");
  for (size_t i = 0; i < outputs.size(); ++i) {
    if (const std::string sentence = unsupported_output(outputs[i]); !sentence.empty())
      return Error{ErrorKind::usage, "--output: " + sentence};
    for (size_t j = 0; j < i; ++j)
      if (outputs[i].lexically_normal() == outputs[j].lexically_normal())
        return Error{ErrorKind::usage, fmt::format("--output: {}: given twice", outputs[i].string())};
  }
  if (wants_layers(options.aovs) && std::none_of(outputs.begin(), outputs.end(), is_exr))
    return Error{ErrorKind::usage, "--aov: only .exr files hold further layers; add -o FILE.exr"};
  for (const fs::path& output : outputs)
    if (Result<void> writable = check_writable(output); !writable.ok()) return writable.error();
  return outputs;
}

ImageMetadata make_metadata(const RenderReport& r, const Camera& camera) {
  ImageMetadata metadata;
  metadata.text = {{"Software", fmt::format("Kindling {}", version())},
                   {"kindling:version", std::string(version())},
                   {"kindling:commandLine", r.command_line},
                   {"kindling:scene", r.scene_file},
                   {"kindling:sceneHash", format_hash(r.scene_hash)},
                   {"kindling:integrator", r.integrator},
                   {"kindling:accelerator", r.accelerator_description}};
  metadata.integers = {{"kindling:seed", static_cast<int>(r.seed)},
                       {"kindling:samplesPerPixel", static_cast<int>(r.statistics.samples_per_pixel)},
                       {"kindling:threads", r.statistics.threads}};
  metadata.numbers = {{"kindling:loadSeconds", static_cast<float>(r.times.load_s)},
                      {"kindling:buildSeconds", static_cast<float>(r.times.build_s)},
                      {"kindling:renderSeconds", static_cast<float>(r.times.render_s)}};
  metadata.world_to_camera = camera.world_to_camera();
  metadata.world_to_ndc = camera.world_to_ndc();
  return metadata;
}

Result<void> write_text_file(const fs::path& path, std::string_view text) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file.ok()) return file.error();
  file.value().write(text.data(), text.size());
  return file.value().commit();
}

} // namespace kindling::app
