// Metadata of images that are made from an accumulation.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/output/render_metadata.h"

#include "renderer/app/text/text_format.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace kindling::app {

namespace {

// The samples of every pixel that adaptive sampling has not stopped, as a render counts them.
uint32_t finished_samples(const Coverage& coverage) {
  uint32_t min_samples = std::numeric_limits<uint32_t>::max();
  uint32_t max_samples = 0;
  for (size_t i = 0; i < coverage.block_count(); ++i) {
    uint32_t count = 0;
    for (const SampleRange& span : coverage[i].spans) count += span.count();
    max_samples = std::max(max_samples, count);
    if (!coverage[i].stopped) min_samples = std::min(min_samples, count);
  }
  return std::min(min_samples, max_samples);
}

} // namespace

std::string training_flag(uint64_t training_paths) { return fmt::format(" --training-paths {}", training_paths); }
std::string light_paths_flag(float fraction) { return fmt::format(" --light-paths {}", fraction); }
std::string direct_samples_flag(int samples) { return fmt::format(" --direct-samples {}", samples); }
std::string reflection_samples_flag(int samples) { return fmt::format(" --reflection-samples {}", samples); }
std::string photons_flag(float fraction) { return fmt::format(" --photons {}", fraction); }
std::string path_reuse_flag(int pixels) { return fmt::format(" --path-reuse {}", pixels); }

ImageMetadata metadata_of(const Accumulation& accumulation) {
  const RenderState& state = accumulation.state;
  ImageMetadata metadata = metadata_from_json(accumulation.identity.metadata);
  std::string command_line = "kindling";
  for (const std::string& argument : accumulation.identity.arguments) command_line += ' ' + shell_quote(argument);
  if (state.work.training_paths) command_line += training_flag(*state.work.training_paths);
  if (state.work.training_paths && state.work.light_paths) command_line += light_paths_flag(*state.work.light_paths);
  if (state.work.training_paths && state.work.photons) command_line += photons_flag(*state.work.photons);
  if (state.work.training_paths && state.work.direct_samples)
    command_line += direct_samples_flag(*state.work.direct_samples);
  if (state.work.training_paths && state.work.reflection_samples)
    command_line += reflection_samples_flag(*state.work.reflection_samples);
  if (state.work.training_paths && state.work.path_reuse) command_line += path_reuse_flag(*state.work.path_reuse);
  if (!accumulation.identity.arguments.empty()) metadata.text["kindling:commandLine"] = command_line;
  metadata.integers["kindling:samplesPerPixel"] = static_cast<int>(finished_samples(state.coverage));
  metadata.integers["kindling:processes"] = static_cast<int>(state.work.runs);
  metadata.integers.erase("kindling:threads"); // differs among processes
  metadata.numbers["kindling:renderSeconds"] = static_cast<float>(state.work.render_s);
  metadata.numbers.erase("kindling:loadSeconds");
  metadata.numbers.erase("kindling:buildSeconds");
  return metadata;
}

} // namespace kindling::app
