// Adds device, threads, tiles and schedule of the command line to the settings of the render loop.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/render/render_image.h"

namespace kindling::app {

RenderSettings make_render_settings(const RenderOptions& options, const V2i& size_px) {
  RenderSettings settings = to_render_settings(options, size_px);
  settings.device = options.device;
  settings.device_memory_bytes = options.device_memory_bytes;
  settings.threads = options.threads;
  settings.tile_size_px = options.tile_size_px;
  settings.schedule = options.schedule;
  return settings;
}

} // namespace kindling::app
