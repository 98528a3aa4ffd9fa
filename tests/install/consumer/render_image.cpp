// A small image of a glTF file with the installed library, from loading to the film.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/camera.h"
#include "renderer/import/load_gltf.h"
#include "renderer/scene/pose.h"
#include "renderer/session/render_session.h"
#include "renderer/world/build_world.h"

#include <cmath>
#include <cstdio>
#include <utility>

namespace {

int fail(const char* what, const kindling::Error& error) {
  std::printf("%s: %s\n", what, error.message.c_str());
  return 1;
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  auto scene = kindling::load_gltf(argv[1], {}, nullptr);
  if (!scene.ok()) return fail("load", scene.error());
  auto posed = kindling::pose_scene(scene.value(), {});
  if (!posed.ok()) return fail("pose", posed.error());
  if (posed.value().cameras.empty()) return fail("camera", {.message = "the scene has none"});
  const kindling::PosedCamera& view = posed.value().cameras.front();

  kindling::RenderSettings settings;
  settings.size_px = {32, 32};
  settings.samples_per_pixel = 4;
  const kindling::Camera camera(scene.value().cameras[static_cast<size_t>(view.camera)], view.camera_to_world,
                                settings.size_px);
  auto world = kindling::build_world(std::move(scene).value(), std::move(posed).value(), {}, nullptr, nullptr);
  if (!world.ok()) return fail("build", world.error());
  auto outcome = kindling::render(*world.value(), camera, settings, nullptr, nullptr);
  if (!outcome.ok()) return fail("render", outcome.error());

  double sum = 0.0;
  for (const float value : outcome.value().film.resolve(kindling::Aov::beauty)) {
    if (!std::isfinite(value) || value < 0.0f) return fail("film", {.message = "a value that is no radiance"});
    sum += static_cast<double>(value);
  }
  std::printf("mean radiance %g\n", sum / (32.0 * 32.0 * 3.0));
  return sum > 0.0 ? 0 : 1;
}
