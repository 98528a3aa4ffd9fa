// Options of the commands as plain structs with their defaults.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/options/accelerator_variant.h"
#include "renderer/app/options/frame_options.h"
#include "renderer/app/options/plugin_spec.h"
#include "renderer/app/options/progress_mode.h"
#include "renderer/app/options/resume_options.h"
#include "renderer/app/options/shootout_clock.h"
#include "renderer/app/tev/tev_address.h"
#include "renderer/base/math.h"
#include "renderer/base/result.h"
#include "renderer/device/make_device.h"
#include "renderer/distributed/work_parts.h"
#include "renderer/film/cryptomatte.h"
#include "renderer/session/checkpoint.h"
#include "renderer/session/image_settings.h"

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace kindling::app {

// Options of `kindling render`: the settings that decide the image (session/image_settings.h), and
// everything else.
struct RenderOptions : WorldSettings, ImageSettings {
  std::filesystem::path scene_file;
  // Empty: the scene's stem with .png, or -####.png for frames, in the current folder.
  std::vector<std::filesystem::path> outputs;
  std::filesystem::path camera_path; // a file whose camera replaces those of the scene; empty: none
  FrameOptions frames;
  std::optional<double> turntable_s; // of --turntable, which becomes FrameOptions::turntable
  WorkPart part;                     // of the samples, the pixels, or both
  CheckpointOptions checkpoint;
  std::optional<WhittedTracer> tracer; // preset of the Whitted tracer and its accelerator

  bool exr_half = true;
  int png_bits = 8;
  int jpeg_quality = 95;                  // 1 to 100
  int matte_levels = kDefaultMatteLevels; // WriteOptions::matte_levels
  std::string view;
  std::optional<double> exposure_stops = 0.0; // none: auto
  std::string ocio_config;

  // From the start of the process, or of a later frame, until the image is written. ImageSettings::
  // time_limit_s gets what is left of it when the render begins.
  std::optional<double> time_limit_total_s;

  std::optional<Denoising> resumed_denoising; // of `kindling resume`, which cannot change what the film records
  [[nodiscard]] Denoising denoising_of_images() const { return resumed_denoising.value_or(denoising); }

  std::optional<V2i> replay_pixel; // if set, one sample is replayed and no image is written
  uint32_t replay_sample = 0;

  DeviceKind device = DeviceKind::cpu;
  std::optional<uint64_t> device_memory_bytes; // RenderSettings::device_memory_bytes
  int threads = 0;                             // 0: all cores
  int tile_size_px = 32;
  Schedule schedule = Schedule::tiles;

  std::vector<std::string> arguments; // of the command line, without the program's name

  std::filesystem::path stats_file;
  std::optional<TevAddress> tev; // of the viewer that shows the growing image
  ProgressMode progress = ProgressMode::automatic;
  bool quiet = false;
  bool verbose = false;
};

enum class InfoTopic { everything, cameras, scenes, variants, extensions, extension_table };

struct InfoOptions {
  std::filesystem::path scene_file; // or a .kacc file; empty only for InfoTopic::extensions and extension_table
  InfoTopic topic = InfoTopic::everything;
  std::string scene_name;   // name or index of the scene whose cameras are listed; empty: the default scene
  std::string variant_name; // name or index of the variant whose materials are counted; empty: the primitives' own
  bool json = false;
  bool strict = false; // refuses what a render repairs
  int threads = 0;
  RenderOptions image; // the image of the memory estimate: size, AOVs, limit on texture memory
};

// Options of `kindling shootout`.
struct ShootoutOptions {
  std::vector<std::filesystem::path> scene_files;
  RenderOptions view; // uses its scene, camera, light, size, --quiet and --verbose

  std::vector<AcceleratorVariant> accelerators{{accel::Kind::embree},
                                               {accel::Kind::embree, accel::Quality::balanced, false},
                                               {accel::Kind::embree, accel::Quality::best, false},
                                               {accel::Kind::kdtree}};
  std::vector<PluginSpec> plugins;
  double plugin_time_limit_s = 60.0;    // for each build and each pass over a set of rays
  std::optional<DeviceKind> device;     // host or gpu, which traces all rays of a set together; unset: none
  std::optional<accel::SimdTarget> isa; // for accelerators that name no instruction set
  uint32_t rays_per_kind = 1 << 17;
  uint32_t batch_size = 256;
  uint32_t repeat = 5;
  uint32_t build_repeat = 3;
  ShootoutClock clock = ShootoutClock::wall;
  bool embree_calls = true; // also races Embree's packets and streams
  int threads = 0;          // for loading and parallel builds; 0: all cores
  int heat_map_width_px = 320;

  std::filesystem::path rays_file;
  std::filesystem::path record_rays_file;
  bool compare = false; // the two files in place of scenes are JSON reports, which are compared
  std::filesystem::path json_file;
  std::filesystem::path csv_file;
  std::filesystem::path html_file;
};

// Options of `kindling merge`.
struct MergeOptions {
  std::vector<std::filesystem::path> parts;
  bool allow_missing = false;
  RenderOptions image; // uses its outputs, their formats and view, --stats, --quiet and --verbose
};

// Options of `kindling denoise`.
inline constexpr int kMaxNeighbors = 8;

struct DenoiseOptions {
  DenoiseOptions() { image.denoising = Denoising::best; }

  std::filesystem::path file; // .exr or .kacc; with frames the name has ####
  std::vector<int> frames;    // numbers; empty: one image, with a literal name
  int neighbors = 2;          // frames before and after each one that are blended with it
  RenderOptions image;        // uses its outputs, their formats and view, --denoise, --threads, --quiet and --verbose
};

// A factor on the light of a group.
struct LightFactor {
  std::string group;
  Rgb factor{1.0f};
};

// Options of `kindling relight`.
struct RelightOptions {
  std::filesystem::path file;       // .exr or .kacc
  std::vector<LightFactor> factors; // of different groups
  Rgb others{1.0f};                 // the factor of all other groups
  RenderOptions image; // uses its outputs, their formats and view, --denoise, --threads, --quiet and --verbose
};

// Options of `kindling scaling`.
struct ScalingOptions {
  std::vector<std::filesystem::path> scene_files;
  RenderOptions image; // uses the settings of the image, --quiet and --verbose

  std::vector<AcceleratorVariant> accelerators{{accel::Kind::kdtree}, {accel::Kind::embree}};
  std::vector<int> thread_counts; // increasing from 1; empty: default_thread_counts(max_threads)
  int max_threads = 0;            // 0: all cores
  std::vector<Schedule> schedules{Schedule::tiles, Schedule::regions};
  std::optional<DeviceKind> device; // host or gpu, measured beside the processor; unset: none
  uint32_t repeat = 3;
  std::optional<double> seconds; // sets the samples per pixel by the time of one thread; unset: those of `image`
  bool quick = false;

  std::filesystem::path json_file;
  std::filesystem::path csv_file;
  std::filesystem::path svg_file;
};

// Options of `kindling view`.
struct LiveOptions {
  RenderOptions image; // uses the settings of scene and image, its view and exposure, --quiet and --verbose
  std::string listen = "127.0.0.1";
  std::optional<int> port;            // 0: any free one; unset: kDefaultViewPort, or any free one if that is taken
  std::vector<std::string> passed_on; // flags that the page does not change, for its command lines
};
inline constexpr int kDefaultViewPort = 8600;

} // namespace kindling::app
