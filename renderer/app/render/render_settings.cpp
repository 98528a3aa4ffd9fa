// From options to the session's settings.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/render/render_image.h"

namespace kindling::app {

RenderSettings make_render_settings(const RenderOptions& options, const V2i& size_px) {
  RenderSettings settings;
  settings.integrator = options.integrator;
  settings.size_px = size_px;
  settings.crop = options.crop;
  settings.samples_per_pixel = options.samples_per_pixel();
  settings.planned_samples = options.planned_samples();
  settings.adaptive = options.adaptive;
  settings.outliers = options.outliers;
  settings.time_limit_s = options.time_limit_s;
  settings.seed = options.seed;
  settings.guiding = options.guiding;
  settings.sampler = options.sampler;
  settings.filter = PixelFilter(options.filter);
  settings.aovs = options.aovs;
  if (settings.adaptive.enabled()) settings.aovs.insert(Aov::samples);
  settings.threads = options.threads;
  settings.tile_size_px = options.tile_size_px;
  settings.schedule = options.schedule;
  return settings;
}

} // namespace kindling::app
