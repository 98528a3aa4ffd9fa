// The kinds of integrators, and their settings.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/integrator/caustics.h"
#include "renderer/integrator/whitted_settings.h"
#include "renderer/world/light_groups/light_grouping.h"

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace kindling {

enum class IntegratorKind : uint8_t {
  path,
  whitted,
  ambient_occlusion,
  albedo,
  normal,
  geometric_normal,
  depth,
  uv,
  barycentric,
  instance,
  material
};
[[nodiscard]] std::string_view integrator_name(IntegratorKind kind);
[[nodiscard]] std::optional<IntegratorKind> integrator_from_name(std::string_view name);
[[nodiscard]] std::span<const IntegratorKind> all_integrators();

// Maximum of each limit on bounces below, so that counters of 16 bits can hold the bounces of a
// path.
inline constexpr int kMaxBounces = 4096;

// Maximum of IntegratorSettings::direct_samples.
inline constexpr int kMaxDirectSamples = 16;

// Maximum of IntegratorSettings::reflection_samples.
inline constexpr int kMaxReflectionSamples = 4;

// Maximum of IntegratorSettings::manifold_samples.
inline constexpr int kMaxManifoldSamples = 16;

// Maximum of IntegratorSettings::environment_filter.
inline constexpr float kMaxEnvironmentFilter = 64.0f;

// Maximum of IntegratorSettings::path_reuse.
inline constexpr uint32_t kMaxPathReuse = 8;

struct IntegratorSettings {
  IntegratorKind kind = IntegratorKind::path;
  int max_bounces = 8; // reflections of a path after its first surface, diffuse and glossy; 0: direct light only
  int max_diffuse_bounces = 8;
  int max_glossy_bounces = 8;
  int max_transmission_bounces = 16; // counted apart: a glass has four surfaces, and one behind another is common
  int roulette_start_bounce = 2;     // first bounce with Russian roulette
  int direct_samples = 1;            // of lights at a path's first surface; IntegratorKind::path alone
  int reflection_samples = 0;        // of the environment, by the glossy lobes of the first surface; likewise
  int path_reuse = 1; // pixels that share their paths (reuse_paths.h): 1, 2, 4 or 8; IntegratorKind::path alone
  float clamp_direct = kInfinity;      // maximum of any component of a sample's directly lit part
  float clamp_indirect = kInfinity;    // the same for light that was reflected more than once
  Caustics caustics = Caustics::full;  // treatment of light found through narrow lobes behind wide ones
  float ao_distance_m = 0.0f;          // ambient occlusion: 0 means a tenth of the scene's diagonal
  bool environment_visible = true;     // to camera rays
  std::optional<Rgb> background;       // seen by camera rays in place of the environment, alpha 1
  bool transparent_background = false; // camera rays that leave give alpha 0
  float light_paths = 0.0f; // fraction of the samples that have a light path (LightPaths); IntegratorKind::path alone
  // The pixels that are rendered, from the first up to the last, which is left out; the same: all.
  // Light paths are those of the whole image, and are joined to the camera for these pixels alone.
  V2i crop_min{0}, crop_end{0};
  float photons = 0.0f; // paths of photons for each sample of a pixel (PhotonMaps); IntegratorKind::path alone
  uint32_t samples_per_photon_map = 0; // of a pixel, in pilots; 0: PhotonMaps::samples_per_map()
  // Widths, in pixels over the number of samples, of what glass and mirrors show of the environment
  // in one sample (specular_cone()); 0: a point. IntegratorKind::path alone.
  float environment_filter = 1.0f;
  // First walks to lamps without a size by way of smooth glass (manifold_walk.h), at each surface
  // of a path; 0: none; IntegratorKind::path alone.
  int manifold_samples = 0;
  // Light samples of an environment image come from a PresampledEnvironment; IntegratorKind::path
  // alone.
  bool presamples_environment = true;
  LightGrouping light_groups = LightGrouping::off; // sums of the film by light group; IntegratorKind::path alone
  uint32_t batch_size = 256;                       // path states that a thread advances together, a multiple of 64
  WhittedSettings whitted; // for IntegratorKind::whitted, which ignores the limits, clamps and caustics above

  // Returns the most shadow rays that a path has at a surface.
  [[nodiscard]] uint32_t max_shadow_rays() const { return static_cast<uint32_t>(direct_samples + reflection_samples); }
};

} // namespace kindling
