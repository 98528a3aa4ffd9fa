// Fills in the request for the memory budget of one image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/setup/memory_warning.h"

#include "renderer/app/setup/available_memory.h"
#include "renderer/app/terminal/process_info.h"

#include <tbb/task_arena.h>

namespace kindling::app {

void add_environment(const Environment* environment, const RenderOptions& options, MemoryRequest& request) {
  if (environment != nullptr) request.environment_texels = environment->memory_bytes() / MemoryCosts::kEnvironmentTexel;
  request.decodes_hdr = options.env_file.extension() == ".hdr";
}

std::optional<std::string> warn_of_render_memory(const RenderScene& scene, const PosedImage& image,
                                                 const RenderOptions& options) {
  MemoryRequest request;
  request.size_px = options.crop ? options.crop->max - options.crop->min : image.size_px;
  request.aovs = options.recorded_aovs();
  request.denoising = options.denoising_of_images();
  request.threads = tbb::this_task_arena::max_concurrency();
  request.texture_memory_bytes = options.texture_memory_bytes;
  add_environment(scene.environment.get(), options, request);
  const MemoryBudget budget = memory_budget(memory_demand(scene.scene, image.posed), request);
  return warn_of_memory(budget, options.accelerator, resident_bytes(), available_memory_bytes());
}

} // namespace kindling::app
