// Small scenes that exercise every technique of the path tracer, with settings for comparisons.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/integrator.h"
#include "renderer/scene/scene.h"
#include "tests/unbiased/plain_tracer.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <span>
#include <vector>

namespace kindling::test {

// A scene or some of its lights.
struct Part {
  Scene scene;
  std::shared_ptr<const Environment> environment;
};

struct TestScene {
  Part whole;
  std::vector<Part> parts; // their light adds up to that of the whole; may be empty
  SceneCamera camera;
  M44f camera_to_world;
  std::vector<M44f> later_cameras; // keys of a moving camera after the first
  std::optional<Shutter> shutter;  // the scene is animated while it is open
  V2i size_px{32, 24};
  int max_bounces = 1;

  uint32_t samples = 4; // per pixel and seed
  bool casters = false; // has surfaces that light paths aim at

  // Bounce limits for comparisons with the plain tracer; none if it cannot find the lights.
  std::vector<int> traced_bounces;
  uint32_t traced_samples = 32;                  // per pixel and seed, by the plain tracer
  std::vector<Aim> aims;                         // for the plain tracer
  std::function<void(IntegratorSettings&)> bias; // changes a setting so that a little light is lost, to be detected

  [[nodiscard]] Camera make_camera() const {
    return {camera, camera_to_world, size_px, CameraMotion{later_cameras, shutter.has_value()}};
  }
};

struct NamedScene {
  const char* name;
  TestScene (*make)();
};
inline void PrintTo(const NamedScene& scene, std::ostream* out) { *out << scene.name; } // for GoogleTest
// Returns all procedural and shipped scenes.
[[nodiscard]] std::span<const NamedScene> all_scenes();

[[nodiscard]] TestScene hall_of_lamps();     // two hundred spheres of several kinds over a floor
[[nodiscard]] TestScene room_with_window();  // closed but for a window to an uneven sky
[[nodiscard]] TestScene metal_under_sun();   // glossy metal under a sky with a small sun
[[nodiscard]] TestScene textured_emitters(); // instances of textured lamps, seen from both sides
[[nodiscard]] TestScene veils();             // layers of BLEND surfaces, some of which shine
[[nodiscard]] TestScene kinds_of_lights();   // rectangles, point, spot and directional lights
[[nodiscard]] TestScene sized_lights();      // a sphere, a spot and a disc in the sky
[[nodiscard]] TestScene layered_materials(); // coats, cloth, leaves, rough glass and thin walls before a sky and a lamp
[[nodiscard]] TestScene caustics();          // glass and metal under a lamp, a sphere and a sun
[[nodiscard]] TestScene coats_and_prisms();  // coats, glossy surfaces and dispersive glass under lamps
[[nodiscard]] TestScene glass_bell();        // a sphere in a bell of glass under a sky with a lamp
[[nodiscard]] TestScene moving_caustics();   // glass and metal that move and deform, before a moving camera
[[nodiscard]] TestScene moving_lamps();      // lamps and a sun that move over glass and metal
[[nodiscard]] TestScene cornell_box();
[[nodiscard]] TestScene material_grid();
[[nodiscard]] TestScene interior();

// Returns a test of light that glass and metal of the scene focus.
[[nodiscard]] TestScene seen_from_above(Scene scene, uint32_t samples);

} // namespace kindling::test
