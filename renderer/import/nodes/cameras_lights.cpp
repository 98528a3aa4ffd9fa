// Reads cameras and KHR_lights_punctual.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/extensions.h"
#include "renderer/import/nodes/camera_extras.h"
#include "renderer/import/nodes/light_extras.h"
#include "renderer/import/nodes/nodes.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cfloat>
#include <cmath>
#include <limits>
#include <optional>
#include <string_view>
#include <utility>

namespace kindling::gltf {

using nlohmann::json;

namespace {

// A cone whose inner angle is not below the outer one: as scene/animated_members.cpp limits it.
constexpr float kMinCone_rad = 1e-3f;
constexpr float kSharpCone = 0.999f; // inner angle over outer angle

// Returns the numbers of a projection that are sizes; 0 stands for one that is absent.
std::array<std::pair<std::string_view, double>, 3> sizes_of(const tinygltf::Camera& core) {
  if (core.type == "perspective")
    return {{{"yfov", core.perspective.yfov},
             {"aspectRatio", core.perspective.aspectRatio},
             {"znear", core.perspective.znear}}};
  return {{{"xmag", core.orthographic.xmag}, {"ymag", core.orthographic.ymag}, {"znear", core.orthographic.znear}}};
}

// Returns the fault of a projection that shows nothing.
std::optional<ImportFailure> fault_of(const tinygltf::Camera& core, const std::string& pointer) {
  const auto fault = [&](std::string_view place, std::string_view message, std::string_view code) {
    return ImportFailure{{ErrorKind::scene_invalid, place_message(fmt::format("{}{}", pointer, place), message, code)}};
  };
  if (core.type == "perspective" && core.perspective.yfov >= 3.14159265358979) {
    return fault("/perspective/yfov", fmt::format("{}, expected an angle below pi", core.perspective.yfov),
                 "CAMERA_YFOV_GEQUAL_PI");
  }
  if (core.type == "orthographic" && (core.orthographic.xmag == 0.0 || core.orthographic.ymag == 0.0))
    return fault("/orthographic", "xmag or ymag is 0, expected other values", "CAMERA_XMAG_YMAG_ZERO");
  // The squares of all numbers are finite and not 0 in single precision.
  for (const auto& [name, value] : sizes_of(core))
    if (value != 0.0 && !(std::abs(value) >= 1e-18 && std::abs(value) <= 1e18))
      return fault(fmt::format("/{}/{}", core.type, name),
                   fmt::format("{}, expected a number from 1e-18 to 1e18 in size", value), "VALUE_NOT_IN_RANGE");
  return std::nullopt;
}

// Removes a camera from its nodes. It stays in the list, so that indices of others do not change.
void forget_camera(Document& document, size_t camera) {
  for (tinygltf::Node& node : document.core.nodes)
    if (node.camera == static_cast<int>(camera)) node.camera = kNone;
}

} // namespace

void import_cameras(Document& document, Scene& scene, Warnings& warnings) {
  const auto f = [](double value) { return static_cast<float>(value); };
  for (size_t i = 0; i < document.core.cameras.size(); ++i) {
    const tinygltf::Camera& core = document.core.cameras[i];
    const json& object = (*document.json)["cameras"][i];
    const std::string pointer = fmt::format("/cameras/{}", i);
    SceneCamera camera;
    camera.name = core.name;
    if (const auto fault = fault_of(core, pointer)) {
      warnings.repair("camera", *fault, "the camera is not used");
      forget_camera(document, i);
      scene.cameras.push_back(std::move(camera));
      continue;
    }
    // tinygltf has checked that the object of this type exists.
    if (core.type == "perspective") {
      const json& lens = object["perspective"];
      camera.kind = SceneCamera::Kind::perspective;
      camera.yfov_rad = f(core.perspective.yfov);
      if (lens.contains("aspectRatio")) camera.aspect_ratio = f(core.perspective.aspectRatio);
      camera.znear = f(core.perspective.znear);
      if (lens.contains("zfar")) camera.zfar = f(core.perspective.zfar);
    } else {
      camera.kind = SceneCamera::Kind::orthographic;
      camera.xmag = f(std::abs(core.orthographic.xmag));
      camera.ymag = f(std::abs(core.orthographic.ymag));
      camera.znear = f(core.orthographic.znear);
      camera.zfar = f(core.orthographic.zfar);
    }
    if (!(camera.zfar > camera.znear)) {
      warnings.repair("zfar", fmt::format("{}/{}", pointer, core.type),
                      fmt::format("zfar {} is not above znear {}", camera.zfar, camera.znear),
                      "CAMERA_ZFAR_LEQUAL_ZNEAR", "they are ignored");
      camera.znear = 0.0f;
      camera.zfar = camera.kind == SceneCamera::Kind::perspective ? std::numeric_limits<float>::infinity() : FLT_MAX;
    }
    read_camera_extras(object, pointer, camera, warnings);
    scene.cameras.push_back(std::move(camera));
  }
}

void import_lights(const Document& document, Scene& scene, Warnings& warnings) {
  const json* extension = find_extension(*document.json, "KHR_lights_punctual");
  if (extension == nullptr) return;
  const json& lights = (*extension)["lights"];
  for (size_t i = 0; i < lights.size(); ++i) {
    const json& object = lights[i];
    PunctualLight light;
    light.name = object.value("name", "");
    const auto type = object["type"].get<std::string>();
    light.kind = type == "spot"    ? PunctualLight::Kind::spot
                 : type == "point" ? PunctualLight::Kind::point
                                   : PunctualLight::Kind::directional;
    if (const auto color = object.find("color"); color != object.end()) {
      light.color = {(*color)[0].get<float>(), (*color)[1].get<float>(), (*color)[2].get<float>()};
    }
    light.intensity = static_cast<float>(number_or(object, "intensity", 1.0));
    if (object.contains("range")) light.range_m = static_cast<float>(object["range"].get<double>());
    const std::string pointer = fmt::format("/extensions/KHR_lights_punctual/lights/{}", i);
    read_light_extras(object, pointer, light, warnings);
    if (light.kind == PunctualLight::Kind::spot) {
      const auto spot = object.find("spot");
      if (spot == object.end()) {
        warnings.repair("spot", pointer, "a spot light without 'spot'", "UNDEFINED_PROPERTY", "it has default angles");
      } else {
        light.inner_cone_rad = static_cast<float>(number_or(*spot, "innerConeAngle", 0.0));
        light.outer_cone_rad = static_cast<float>(number_or(*spot, "outerConeAngle", kPi / 4.0));
      }
      if (!(light.outer_cone_rad > light.inner_cone_rad)) {
        warnings.repair(
            "cone", pointer + "/spot",
            fmt::format("outerConeAngle {} is not above innerConeAngle {}", light.outer_cone_rad, light.inner_cone_rad),
            "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES", "the cone has a sharp edge");
        light.outer_cone_rad = std::max(light.outer_cone_rad, kMinCone_rad);
        light.inner_cone_rad = light.outer_cone_rad * kSharpCone;
      }
    }
    scene.lights.push_back(std::move(light));
  }
}

} // namespace kindling::gltf
