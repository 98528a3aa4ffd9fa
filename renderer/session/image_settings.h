// The settings that decide an image: what its World is built from, and how it is seen and sampled.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/make_accelerator.h"
#include "renderer/base/math.h"
#include "renderer/camera/place_camera.h"
#include "renderer/denoise/denoising.h"
#include "renderer/film/aov.h"
#include "renderer/film/film.h"
#include "renderer/integrator/integrator.h"
#include "renderer/sampling/pixel_filter.h"
#include "renderer/scene/shutter.h"
#include "renderer/session/adaptive_sampling.h"
#include "renderer/session/render_session.h"
#include "renderer/world/builtin_environment.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

inline constexpr uint32_t kDefaultSamplesPerPixel = 64;
// With a noise threshold and without a number of samples: the maximum of a pixel.
inline constexpr uint32_t kDefaultMaxSamplesPerPixel = 1024;
// With a time limit and without a number of samples: more than any render reaches.
inline constexpr uint32_t kUnlimitedSamplesPerPixel = 1U << 20;

// Sizes of the lights for which the file gives none. Unset: such lights have no extent.
struct LightOptions {
  std::optional<double> radius_m;      // of point and spot lights, measured luminaires included
  std::optional<double> sun_angle_deg; // angular diameter of directional lights
};

// The lens. Each unset member is taken from the file's camera.
struct LensOptions {
  bool pinhole = false; // no lens, even if the file's camera has one
  std::optional<double> f_stop;
  std::optional<double> focal_length_mm;
  std::optional<double> focus_distance_m;
  std::optional<V2i> focus_pixel; // of the whole image: the surface seen there is in focus
  std::optional<int> blades;
  std::optional<double> rotation_deg;
  std::optional<double> anamorphic_ratio;
  std::optional<double> cats_eye;
};

// A turn of the camera about an axis through a point, as on a turntable.
struct CameraTurn {
  double angle_deg = 0.0;     // counter-clockwise as seen from the end of the axis
  V3f axis{0.0f, 1.0f, 0.0f}; // of any length but 0
  std::optional<V3f> around;  // unset: an orbit's target, else the point in view nearest to the center of the scene
};

// Differences between an image and the frames before and after it, for motion vectors.
struct FrameStep {
  double time_s = 1.0 / 24.0; // of the animations; 0: they are static. Without meaning for an image in the rest pose
  double turn_deg = 0.0;      // of ImageSettings::turn
  // In place of ImageSettings::own_camera; unset: the same one.
  std::optional<PlacedCamera> previous_camera, next_camera;
};

// The time for which the shutter is open, relative to ImageSettings::time_s. Set either `interval`
// or the other two. If none is set the camera's own shutter is used.
struct ShutterOptions {
  std::optional<Shutter> interval;
  std::optional<double> angle_deg; // of a rotary shutter that opens at the time of the image; 360: the whole frame
  std::optional<double> frames_per_s;
};

// Settings that a World is built from, beside the scene file.
struct WorldSettings {
  std::string scene_name;   // name or index; empty: the file's default scene
  std::string variant_name; // name or index; empty: the primitives' own materials

  std::filesystem::path env_file;    // equirectangular image; empty: none
  double env_rotation_deg = 0.0;     // counter-clockwise about +y
  double env_intensity = 1.0;        // multiplies the radiance of the image or the color
  std::optional<Rgb> env_color;      // a constant environment, in place of an image
  Studio studio = Studio::automatic; // the built-in environment, if none is given here
  LightOptions lights;
  double point_size_px = 2.0; // diameter of points and width of lines, at the camera of the first image
  bool outlines = false;      // shows lines along edges of triangles of their mesh

  accel::Kind accelerator = accel::Kind::kdtree;
  accel::Quality quality = accel::Quality::balanced;
  bool robust = true;                           // Embree's robust mode
  std::optional<accel::SimdTarget> simd;        // of the kd-tree's kernels; unset: the best that the processor runs
  std::optional<uint64_t> texture_memory_bytes; // unset: no bound. Does not change the image
  bool follow_links = false;                    // also reads files behind links that lead out of the scene's folder
};

// The backs of single-sided faces (doubleSided: false) for rays of the camera.
enum class Backfaces : uint8_t {
  show,
  cull,     // such rays pass through them
  automatic // cull where they are in the way of much else
};
[[nodiscard]] std::string_view backfaces_name(Backfaces backfaces); // "show", "cull", "auto"
[[nodiscard]] std::optional<Backfaces> backfaces_from_name(std::string_view name);

// Settings of the camera, the sampling and the integrator.
struct ImageSettings {
  std::optional<V2i> size_px; // unset: 1280 pixels on the longer side, by the camera's aspect ratio
  double scale = 1.0;         // multiplies the size
  std::optional<PixelRect> crop;

  std::string camera;                     // name or index; empty: the first, or one fitted to the scene if it has none
  std::optional<PlacedCamera> own_camera; // replaces the scene's cameras
  std::optional<V3f> orbit;               // theta in degrees, phi in degrees, radius in meters: camera on a sphere
  V3f target{0.0f, 0.0f, 0.0f};           // center of the orbit
  std::optional<double> orthographic_m;   // height of the image of an orbit that has no perspective
  std::optional<CameraTurn> turn;         // of the camera that these give
  std::optional<double> yfov_deg;         // vertical field of view of a perspective camera
  std::optional<double> time_s;           // of the animations; unset: the rest pose
  LensOptions lens;
  ShutterOptions shutter;
  Backfaces backfaces = Backfaces::automatic;
  FrameStep frame_step; // used with AovSet::needs_motion()
  // Names of nodes (name_surfaces()) which, with all nodes below them, show nothing but the shadows
  // on them. Then the background must be transparent.
  std::vector<std::string> shadow_catchers;
  bool shadow_catchers_of_file = false; // also those that the file marks (Node, Material::shadow_catcher)

  std::optional<uint32_t> spp;         // samples per pixel; the maximum with a noise threshold
  std::optional<uint32_t> planned_spp; // sample count the pattern is designed for; unset: spp
  AdaptiveSettings adaptive;
  SampleRateKind sample_rates = SampleRateKind::automatic;
  std::optional<double> time_limit_s; // of the render phase
  uint32_t seed = 0;                  // below 2^31, so that image metadata can hold it
  SamplerKind sampler = SamplerKind::blue_noise;
  PixelFilterOptions filter;
  Outliers outliers = Outliers::keep;
  AovSet aovs;
  Denoising denoising = Denoising::off;

  IntegratorSettings integrator; // including the background
  Guiding guiding = Guiding::automatic;
  bool chooses_light_paths = false;       // if integrator.light_paths is 0; see RenderSettings
  bool chooses_direct_samples = true;     // see RenderSettings
  bool chooses_reflection_samples = true; // likewise
  bool chooses_path_reuse = true;         // likewise
  bool chooses_photons = true;            // if integrator.photons is 0; likewise
  std::optional<uint64_t> training_paths; // see RenderSettings

  [[nodiscard]] uint32_t samples_per_pixel() const {
    if (spp) return *spp;
    if (time_limit_s) return kUnlimitedSamplesPerPixel;
    return adaptive.enabled() ? kDefaultMaxSamplesPerPixel : kDefaultSamplesPerPixel;
  }
  [[nodiscard]] bool has_shadow_catchers() const { return shadow_catchers_of_file || !shadow_catchers.empty(); }
  // Returns the AOVs of the film: `aovs`, those that guide a denoiser, and that of shadow catchers.
  [[nodiscard]] AovSet recorded_aovs() const;
  [[nodiscard]] uint32_t planned_samples() const { return planned_spp.value_or(samples_per_pixel()); }
};

// Returns the settings of render() for an image of that size. Threads, tiles and schedule keep
// their defaults.
[[nodiscard]] RenderSettings to_render_settings(const ImageSettings& image, const V2i& size_px);

} // namespace kindling
