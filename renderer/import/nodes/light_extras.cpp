// Reads the key of each kind of light.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/nodes/light_extras.h"

#include "renderer/import/json/kindling_extras.h"

namespace kindling::gltf {
namespace {

constexpr KindlingExtras::Range kRadius{0.0, 1e9, false, "a length from 0 to 1e9, in meters"};
constexpr KindlingExtras::Range kDiameter{0.0, 3.1415927, false, "an angle from 0 to pi, in radians"};

} // namespace

void read_light_extras(const nlohmann::json& object, const std::string& pointer, PunctualLight& light,
                       Warnings& warnings) {
  KindlingExtras extras(object, pointer, warnings);
  if (light.kind == PunctualLight::Kind::directional)
    light.angular_diameter_rad = extras.number("angularDiameter", kDiameter);
  else
    light.radius_m = extras.number("radius", kRadius);
  light.light_group = extras.text("lightGroup").value_or("");
  extras.finish();
}

} // namespace kindling::gltf
