// Translates the settings of an image to those of the render loop.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/image_settings.h"

namespace kindling {

std::string_view backfaces_name(Backfaces backfaces) {
  switch (backfaces) {
  case Backfaces::show: return "show";
  case Backfaces::cull: return "cull";
  case Backfaces::automatic: return "auto";
  }
  return "";
}

std::optional<Backfaces> backfaces_from_name(std::string_view name) {
  for (const Backfaces backfaces : {Backfaces::show, Backfaces::cull, Backfaces::automatic})
    if (name == backfaces_name(backfaces)) return backfaces;
  return std::nullopt;
}

AovSet ImageSettings::recorded_aovs() const {
  AovSet recorded = aovs;
  if (denoising != Denoising::off)
    for (const Aov guide : {Aov::denoising_albedo, Aov::denoising_normal}) recorded.insert(guide);
  if (has_shadow_catchers()) recorded.insert(Aov::shadow_catcher);
  return recorded;
}

RenderSettings to_render_settings(const ImageSettings& image, const V2i& size_px) {
  RenderSettings settings;
  settings.integrator = image.integrator;
  settings.size_px = size_px;
  settings.crop = image.crop;
  settings.samples_per_pixel = image.samples_per_pixel();
  settings.planned_samples = image.planned_samples();
  settings.adaptive = image.adaptive;
  settings.sample_rates = image.sample_rates;
  settings.outliers = image.outliers;
  settings.time_limit_s = image.time_limit_s;
  settings.seed = image.seed;
  settings.guiding = image.guiding;
  settings.training_paths = image.training_paths;
  settings.chooses_light_paths = image.chooses_light_paths;
  settings.chooses_direct_samples = image.chooses_direct_samples;
  settings.chooses_reflection_samples = image.chooses_reflection_samples;
  settings.chooses_path_reuse = image.chooses_path_reuse;
  settings.chooses_photons = image.chooses_photons;
  settings.sampler = image.sampler;
  settings.filter = PixelFilter(image.filter);
  settings.aovs = image.recorded_aovs();
  if (settings.adaptive.enabled() || settings.sample_rates == SampleRateKind::noise) settings.aovs.insert(Aov::samples);
  return settings;
}

} // namespace kindling
