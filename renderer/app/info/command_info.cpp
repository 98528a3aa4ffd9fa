// Loads the file of `kindling info` and prints the requested topic.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/info/command_info.h"

#include "renderer/app/info/accumulation_info.h"
#include "renderer/app/info/scene_info.h"
#include "renderer/app/setup/memory_warning.h"
#include "renderer/app/terminal/exit_code.h"
#include "renderer/app/terminal/progress_display.h"
#include "renderer/app/text/text_format.h"
#include "renderer/facade/choose.h"
#include "renderer/facade/load_environment.h"
#include "renderer/facade/render_stage.h"
#include "renderer/import/load_scene.h"
#include "renderer/scene/strokes.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>
#include <tbb/global_control.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <memory>
#include <utility>

#include <unistd.h>

namespace kindling::app {

namespace {

using Json = nlohmann::ordered_json;

std::string dump(const Json& json) { return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + "\n"; }

std::string list_extensions(bool json) {
  const std::vector<ExtensionSupport> extensions = supported_extensions();
  if (json) {
    Json array = Json::array();
    for (const ExtensionSupport& extension : extensions)
      array.push_back({{"name", extension.name}, {"support", name_of(extension.level)}, {"note", extension.note}});
    return dump(array);
  }
  std::string text;
  for (const ExtensionSupport& extension : extensions) text += std::string(extension.name) + "\n";
  return text;
}

// One scene per line, fields separated by tabs.
std::string list_scenes(const Scene& scene, bool json) {
  std::vector<std::string> names;
  for (const SceneRoot& root : scene.scenes) names.push_back(root.name);
  if (json) return dump(names);
  std::string text;
  for (size_t i = 0; i < names.size(); ++i)
    text += fmt::format("{}\t{}{}\n", i, printable(names[i]),
                        static_cast<int>(i) == scene.default_scene ? "\tdefault" : "");
  return text;
}

std::string list_variants(const Scene& scene, bool json) {
  if (json) return dump(scene.variants);
  std::string text;
  for (const std::string& name : scene.variants) text += printable(name) + "\n";
  return text;
}

std::string list_cameras(const SceneInfo& info, bool json) {
  if (json) return dump(Json::parse(format_info_json(info))["cameras"]);
  std::string text;
  for (size_t i = 0; i < info.cameras.size(); ++i)
    text += fmt::format("{}\t{}\t{}\n", i, printable(info.cameras[i].name), info.cameras[i].kind);
  return text;
}

// The memory request of the image that `kindling render` would make.
Result<MemoryRequest> memory_request(const InfoOptions& options, const Scene& scene, const PosedScene& posed) {
  const Result<std::optional<PlacedCamera>> camera = choose_camera(scene, posed, options.image);
  if (!camera.ok()) return camera.error();
  const Result<V2i> size = choose_size(camera.value() ? &camera.value()->camera : nullptr, options.image);
  if (!size.ok()) return size.error();
  const Result<LoadedEnvironment> environment = load_environment(options.image);
  if (!environment.ok()) return environment.error();
  MemoryRequest request;
  add_environment(environment.value().environment.get(), request);
  request.size_px = size.value();
  request.aovs = options.image.recorded_aovs();
  add_parts_of_light(options.image, scene, posed, request);
  request.denoising = options.image.denoising;
  request.threads = options.threads > 0 ? options.threads : tbb::this_task_arena::max_concurrency();
  request.texture_memory_bytes = options.image.texture_memory_bytes;
  return request;
}

// Drops messages, which describe a render that does not take place.
class Silence final : public ProgressListener {
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view) override {}
  void on_info(std::string_view) override {}
};

// What lights a render with default settings. Consumes the scene if that depends on the view.
Result<LightingInfo> find_lighting(const InfoOptions& options, Scene&& scene, const PosedScene& posed) {
  if (!options.image.env_file.empty()) return LightingInfo{"environment", {}};
  if (posed.image_light != kNone) return LightingInfo{"image light", {}};
  if (!posed.lights.empty()) return LightingInfo{"lights", {}};
  if (std::none_of(scene.materials.begin(), scene.materials.end(), is_lamp)) return LightingInfo{"studio", {}};
  WorldSettings world = static_cast<const WorldSettings&>(options.image);
  world.scene_name = options.scene_name;
  world.variant_name = options.variant_name;
  Result<std::unique_ptr<RenderScene>> taken = take_render_scene(std::move(scene), world);
  if (!taken.ok()) return taken.error();
  Result<PosedImage> image = pose_image(*taken.value(), options.image);
  if (!image.ok()) return image.error();
  Silence silence;
  const Result<RenderStage> stage =
      build_stage(*taken.value(), std::move(image).value(), options.image, false, nullptr, silence);
  if (!stage.ok()) return stage.error();
  const SceneLight& light = stage.value().light;
  if (!light.lit_share) return LightingInfo{"studio", {}}; // its lamps are not placed
  return LightingInfo{light.studio ? "studio and emission" : "emission", light.lit_share};
}

Result<std::string> describe(const InfoOptions& options, Console& console) {
  if (options.topic == InfoTopic::extensions) return list_extensions(options.json);
  if (options.topic == InfoTopic::extension_table)
    return options.json ? list_extensions(true) : extension_table_markdown();

  ProgressDisplay display(console, isatty(STDERR_FILENO) == 1 ? ProgressMode::automatic : ProgressMode::none, {});
  display.start_phase(Phase::load);
  ImportOptions import_options;
  import_options.strict = options.strict;
  import_options.decode_textures = options.topic == InfoTopic::everything; // sizes of textures need their pixels
  import_options.limits.follow_links = options.image.follow_links;
  Result<Scene> scene = load_scene(options.scene_file, import_options, &display);
  display.end_phase();
  if (!scene.ok()) return scene.error();
  if (options.topic == InfoTopic::scenes) return list_scenes(scene.value(), options.json);
  if (options.topic == InfoTopic::variants) return list_variants(scene.value(), options.json);

  const Result<int> root = choose_scene(scene.value(), options.scene_name);
  if (!root.ok()) return root.error();
  const Result<int> variant = show_variant(scene.value(), options.variant_name);
  if (!variant.ok()) return variant.error();
  const SceneStatistics in_file = describe(scene.value());
  const size_t outlines = remove_outlines(scene.value()); // as a render with default settings
  const Result<PosedScene> posed = pose_scene(scene.value(), {root.value(), std::nullopt});
  if (!posed.ok()) return posed.error();
  int shown = root.value() != kNone ? root.value() : scene.value().default_scene;
  if (shown == kNone && !scene.value().scenes.empty()) shown = 0;
  const Result<MemoryRequest> request = memory_request(options, scene.value(), posed.value());
  if (!request.ok()) return request.error();
  SceneInfo info = collect_scene_info(scene.value(), posed.value(), shown, variant.value(), request.value());
  info.in_file = in_file;
  info.outlines = outlines;
  if (options.topic == InfoTopic::cameras) return list_cameras(info, options.json);
  Result<LightingInfo> lighting = find_lighting(options, std::move(scene).value(), posed.value());
  if (!lighting.ok()) return lighting.error();
  info.lighting = std::move(lighting).value();
  return options.json ? format_info_json(info) : format_info_tables(info);
}

// Prints the header of a damaged file before the error.
Result<int> describe_accumulation(const InfoOptions& options) {
  const Result<AccumulationInfo> info = collect_accumulation_info(options.scene_file);
  if (!info.ok()) return info.error();
  if (Result<void> printed =
          print(options.json ? format_accumulation_json(info.value()) : format_accumulation_table(info.value()));
      !printed.ok())
    return printed.error();
  if (info.value().damage) return Error{ErrorKind::input_output, *info.value().damage};
  return kExitOk;
}

} // namespace

Result<int> run_info(const InfoOptions& options, Console& console) {
  std::optional<tbb::global_control> limit;
  if (options.threads > 0)
    limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(options.threads));
  if (names_accumulation(options.scene_file)) return describe_accumulation(options);
  const Result<std::string> text = describe(options, console);
  if (!text.ok()) return text.error();
  if (Result<void> printed = print(text.value()); !printed.ok()) return printed.error();
  return kExitOk;
}

} // namespace kindling::app
