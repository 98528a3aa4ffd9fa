// Imports each file: load_check [-v] [-t] [-s] FILE...
// Prints OK or the error (-v warnings, -t time, -s strictly).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/load_gltf.h"
#include "renderer/scene/pose.h"

#include <chrono>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>

namespace {

class Printer : public kindling::ProgressListener {
 public:
  void on_progress(const kindling::ProgressSnapshot&) override {}
  void on_warning(std::string_view message) override {
    std::printf("  warning: %.*s\n", static_cast<int>(message.size()), message.data());
  }
  void on_info(std::string_view) override {}
};

size_t triangles(const kindling::Scene& scene) {
  size_t count = 0;
  for (const kindling::Mesh& mesh : scene.meshes) {
    for (const kindling::Primitive& primitive : mesh.primitives) count += primitive.triangle_count();
  }
  return count;
}

// Poses every scene at rest and during its animations; returns the first error, or an empty string.
std::string pose_all(const kindling::Scene& scene) {
  for (size_t i = 0; i < scene.scenes.size(); ++i) {
    for (const std::optional<double>& time : {std::optional<double>(), std::optional<double>(0.5)}) {
      const auto posed = kindling::pose_scene(scene, {.scene = static_cast<int>(i), .time_s = time});
      if (!posed) return posed.error().message;
    }
  }
  return {};
}

} // namespace

int main(int argc, char** argv) {
  bool verbose = false;
  bool timed = false;
  kindling::ImportOptions options;
  Printer printer;
  for (int i = 1; i < argc; ++i) {
    if (std::strcmp(argv[i], "-v") == 0) {
      verbose = true;
      continue;
    }
    if (std::strcmp(argv[i], "-t") == 0) {
      timed = true;
      continue;
    }
    if (std::strcmp(argv[i], "-s") == 0) {
      options.strict = true;
      continue;
    }
    const auto start = std::chrono::steady_clock::now();
    const auto scene = kindling::load_gltf(argv[i], options, verbose ? &printer : nullptr);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    if (!scene) {
      std::printf("ERROR %s", scene.error().message.c_str());
    } else if (const std::string what = pose_all(scene.value()); !what.empty()) {
      std::printf("ERROR posing %s: %s", argv[i], what.c_str());
    } else {
      std::printf("OK %s: %zu nodes, %zu meshes, %zu triangles, %016llx", argv[i], scene.value().nodes.size(),
                  scene.value().meshes.size(), triangles(scene.value()),
                  static_cast<unsigned long long>(scene.value().content_hash));
    }
    if (timed) std::printf(" [%.3f s]", seconds);
    std::printf("\n");
    std::fflush(stdout);
  }
  return 0;
}
