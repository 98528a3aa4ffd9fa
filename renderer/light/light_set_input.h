// The lights of a scene, as a LightSet is built from them.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/math.h"
#include "renderer/light/environment.h"
#include "renderer/light/light_frame.h"
#include "renderer/light/light_profile.h"
#include "renderer/texture/texture.h"

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace kindling {

// Emission of a group of triangles: radiance = factor * texture(uv), on the front face or on both.
struct Emission {
  Rgb factor{0.0f};                     // W / (sr m^2), including emissive strength
  const TextureView* texture = nullptr; // sRGB-decoded emission; borrowed; null: factor alone
  bool two_sided = false;               // false: emits on the side where p0, p1, p2 are counterclockwise
  float clearcoat = 0.0f;               // strength of a uniform coat over it; see coat_transmittance()
  bool coated_back = true;              // the coat is also on the back side
};

// World space. The triangle's uv are already transformed for the texture.
struct EmissiveTriangle {
  V3f p0, p1, p2;
  uint32_t emission = 0; // index into LightSetInput::emissions
};

// Keys of a moving triangle after the first: `count` entries of LightSetInput::later_corners. Keys
// are equally spaced over the shutter; corners move linearly between them.
struct CornerKeys {
  uint32_t first = 0;
  uint32_t count = 0; // 0: static
};

// The consecutive triangles of one mesh of the scene, which PerLightSampling treats as one light.
struct EmissiveMesh {
  uint32_t first = 0; // index into LightSetInput::triangles
  uint32_t count = 0;
  std::string name;
  int node = -1;         // of the scene: index, below 0: unknown
  uint32_t material = 0; // likewise
};

// Point, spot and profiled lights with a radius are uniformly emitting spheres: every point of the
// surface emits the light's intensity in that direction over pi radius^2, so that a plane that
// faces the whole sphere receives the irradiance of the point light. They occlude nothing and emit
// inwards as well. Rays that leave a surface hit them (shape_radiance()). Without a radius they are
// points.
//
// `later` holds the frames at the keys after the first, for lights that move over the shutter.
// `source` is the caller's number of a light (LightSet::punctual_source()).
struct PointLight {
  V3f position;
  Rgb intensity; // candela per channel
  std::optional<float> range_m;
  std::string name;
  float radius_m = 0.0f; // below a micrometer: a point
  std::vector<LightFrame> later;
  uint32_t source = 0;
};
// light.intensity is multiplied by the profile's intensity in the direction.
struct ProfiledLight {
  V3f position;
  V3f axes[3];   // unit, of the profile's frame; it is aimed along -axes[2]
  Rgb intensity; // factor per channel
  std::shared_ptr<const LightProfile> profile;
  std::string name;
  float radius_m = 0.0f;
  std::vector<LightFrame> later;
  uint32_t source = 0;
};
struct SpotLight {
  V3f position;
  V3f axis;      // unit, direction of emission
  Rgb intensity; // candela per channel, on the axis
  float cos_inner = 1.0f;
  float cos_outer = 0.0f; // < cos_inner
  std::optional<float> range_m;
  std::string name;
  float radius_m = 0.0f;
  std::vector<LightFrame> later;
  uint32_t source = 0;
};
struct DirectionalLight {
  V3f direction;  // unit, direction of emission
  Rgb irradiance; // lux per channel, on a surface facing it
  std::string name;
  float angular_diameter_rad = 0.0f; // of a uniform disk in the sky, up to pi; below a microradian: a point
  std::vector<LightFrame> later;
  uint32_t source = 0;
};

struct LightSetInput {
  std::vector<Emission> emissions;
  std::vector<EmissiveTriangle> triangles;
  std::vector<V2f> triangle_uvs; // empty, or three per triangle
  std::vector<EmissiveMesh> meshes;
  // Keys of the last triangles, which are posed at the opening of the shutter; empty if all are
  // static.
  std::vector<CornerKeys> moving;
  std::vector<std::array<V3f, 3>> later_corners;
  std::vector<PointLight> points;
  std::vector<SpotLight> spots;
  std::vector<ProfiledLight> profiled;
  std::vector<DirectionalLight> directionals;
  std::shared_ptr<const Environment> environment; // may be null
  V3f scene_center{0.0f};
  float scene_radius_m = 1.0f;
};

} // namespace kindling
