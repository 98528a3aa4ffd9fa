// Prints hashes of camera rays, lenses and projections, for compare_compilers.py.
//
// It includes the sources themselves, so that it needs no library but Imath's headers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/camera/aperture.cpp"
#include "renderer/camera/camera.cpp"
#include "renderer/camera/camera_rays.cpp"
#include "tests/base/result_hash.h"

#include <array>

namespace {

using namespace kindling;
using test::Inputs;
using test::ResultHash;

Camera camera_of(Inputs& inputs, int kind, std::array<M44f, 2>& later) {
  SceneCamera camera;
  camera.yfov_rad = inputs.between(0.1f, 2.0f);
  camera.lens.anamorphic_ratio = inputs.between(0.5f, 2.0f);
  camera.lens.cats_eye = inputs.pick();
  camera.lens.aperture_rotation_rad = inputs.between(-4.0f, 4.0f);
  camera.lens.aperture_blades = kind % 3 == 0 ? 0 : 3 + kind % 5;
  if (kind % 2 == 1) {
    camera.lens.f_stop = inputs.between(1.0f, 8.0f);
    camera.lens.focus_distance_m = inputs.between(0.5f, 20.0f);
  }
  M44f place[3];
  for (M44f& m : place) {
    const float x = inputs.number(), y = inputs.number(), z = inputs.number();
    m = Quatf(1.0f, x, y, z).normalized().toMatrix44();
    for (int k = 0; k < 3; ++k) m[3][k] = inputs.between(-5.0f, 5.0f);
  }
  later = {place[1], place[2]};
  CameraMotion motion;
  if (kind % 4 >= 2) motion.later_transforms = later;
  return {camera, place[0], {640, 480}, motion};
}

void print_rays(const char* name, bool special, int count) {
  Inputs inputs{test::Random(1), special};
  ResultHash hash;
  std::array<M44f, 2> later;
  for (int kind = 0; kind < 16; ++kind) {
    const Camera camera = camera_of(inputs, kind, later);
    for (int i = 0; i < count / 16; ++i) {
      const V2f film(inputs.any_2d(-10.0f, 650.0f)), lens = inputs.random.next_2d();
      const float time = inputs.number();
      const CameraRay ray = camera.generate_ray(film, lens, time);
      hash.add(ray.origin);
      hash.add(ray.direction);
      const RayCone cone = camera.pixel_cone(ray.direction);
      hash.add(cone.width_m);
      hash.add(cone.spread);
      const float depth = inputs.any(0.1f, 30.0f);
      hash.add(camera.confusion(depth));
      const V3f point = inputs.any_3d(-10.0f, 10.0f);
      hash.add(camera.depth(point, time));
      const auto seen = camera.project(point);
      hash.add(seen.has_value());
      if (seen) hash.add(*seen);
    }
  }
  hash.print(name);
}

} // namespace

int main(int argc, char** argv) {
  const int count = test::input_count(argc, argv, 64000);
  test::print_usual_and_special("rays", count, print_rays);
  return 0;
}
