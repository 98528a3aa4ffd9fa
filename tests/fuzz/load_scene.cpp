// The importer and the poses of a scene, for harnesses of glTF and of compressed geometry.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/load_scene.h"

#include "renderer/import/load_gltf.h"
#include "renderer/scene/pose.h"

#include <algorithm>
#include <optional>

namespace kindling::fuzz {
namespace {

// Takes warnings, which must be lines of text.
class Listener final : public ProgressListener {
 public:
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view message) override {
    require(!message.empty() && message.find('\n') == std::string_view::npos, "a warning is one line");
  }
  void on_info(std::string_view) override {}
};

ImportOptions small_options(bool strict) {
  ImportOptions options;
  options.strict = strict;
  options.limits.max_elements_of_small_file = 1 << 18;
  options.limits.elements_per_byte = 64;
  options.limits.max_total_elements = 1 << 22;
  options.limits.max_texture_bytes = 64 << 20;
  options.limits.max_gpu_instances = 1 << 14;
  return options;
}

// At rest, in an animation, and with an open shutter.
void pose_all(const Scene& scene) {
  const size_t count = std::min<size_t>(scene.scenes.size(), 4);
  for (size_t i = 0; i < count; ++i) {
    PoseOptions options{.scene = static_cast<int>(i), .time_s = {}, .shutter = {}};
    static_cast<void>(pose_scene(scene, options));
    options.time_s = 0.5;
    static_cast<void>(pose_scene(scene, options));
    options.shutter = Shutter{0.0, 1.0};
    static_cast<void>(pose_scene(scene, options));
  }
}

} // namespace

void load_and_pose(const std::filesystem::path& path) {
  const auto load = [&](bool strict) { // one scene at a time is in memory
    Listener listener;
    const Result<Scene> scene = load_gltf(path, small_options(strict), &listener);
    if (scene)
      pose_all(scene.value());
    else
      require_good_message(scene.error(), path.string() + ": ");
    return scene.ok();
  };
  const bool strict = load(true);
  const bool repaired = load(false);
  require(repaired || !strict, "a load with repairs accepts what a strict one accepts");
}

std::string make_glb(std::string json, std::string_view bin) {
  const auto number = [](size_t value) {
    const auto word = static_cast<uint32_t>(value);
    return std::string(reinterpret_cast<const char*>(&word), sizeof word);
  };
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string padded(bin);
  padded.resize((padded.size() + 3) / 4 * 4);
  return "glTF" + number(2) + number(12 + 8 + json.size() + 8 + padded.size()) + number(json.size()) + "JSON" + json +
         number(padded.size()) + std::string("BIN\0", 4) + padded;
}

} // namespace kindling::fuzz
