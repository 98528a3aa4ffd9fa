// Reads cameras and KHR_lights_punctual.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/json/extensions.h"
#include "renderer/import/nodes/camera_extras.h"
#include "renderer/import/nodes/light_extras.h"
#include "renderer/import/nodes/nodes.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace kindling::gltf {

using nlohmann::json;

namespace {

// Refuses numbers that are 0 or infinite in single precision, or overflow when they are squared.
void check_size(double value, const std::string& pointer) {
  if (!(std::abs(value) >= 1e-18 && std::abs(value) <= 1e18))
    fail(pointer, fmt::format("{}, expected a number from 1e-18 to 1e18 in size", value), "VALUE_NOT_IN_RANGE");
}

} // namespace

void import_cameras(const Document& document, Scene& scene, Warnings& warnings) {
  const auto f = [](double value) { return static_cast<float>(value); };
  for (size_t i = 0; i < document.core.cameras.size(); ++i) {
    const tinygltf::Camera& core = document.core.cameras[i];
    const json& object = (*document.json)["cameras"][i];
    const std::string pointer = fmt::format("/cameras/{}", i);
    SceneCamera camera;
    camera.name = core.name;
    // tinygltf has checked that the object of this type exists.
    if (core.type == "perspective") {
      const json& lens = object["perspective"];
      camera.kind = SceneCamera::Kind::perspective;
      if (core.perspective.yfov >= 3.14159265358979) {
        fail(pointer + "/perspective/yfov", fmt::format("{}, expected an angle below pi", core.perspective.yfov),
             "CAMERA_YFOV_GEQUAL_PI");
      }
      check_size(core.perspective.yfov, pointer + "/perspective/yfov");
      if (lens.contains("aspectRatio")) check_size(core.perspective.aspectRatio, pointer + "/perspective/aspectRatio");
      check_size(core.perspective.znear, pointer + "/perspective/znear");
      camera.yfov_rad = f(core.perspective.yfov);
      if (lens.contains("aspectRatio")) camera.aspect_ratio = f(core.perspective.aspectRatio);
      camera.znear = f(core.perspective.znear);
      if (lens.contains("zfar")) camera.zfar = f(core.perspective.zfar);
    } else {
      camera.kind = SceneCamera::Kind::orthographic;
      camera.xmag = f(std::abs(core.orthographic.xmag));
      camera.ymag = f(std::abs(core.orthographic.ymag));
      if (core.orthographic.xmag == 0.0 || core.orthographic.ymag == 0.0) {
        fail(pointer + "/orthographic", "xmag or ymag is 0, expected other values", "CAMERA_XMAG_YMAG_ZERO");
      }
      check_size(core.orthographic.xmag, pointer + "/orthographic/xmag");
      check_size(core.orthographic.ymag, pointer + "/orthographic/ymag");
      if (core.orthographic.znear != 0.0) check_size(core.orthographic.znear, pointer + "/orthographic/znear");
      camera.znear = f(core.orthographic.znear);
      camera.zfar = f(core.orthographic.zfar);
    }
    if (!(camera.zfar > camera.znear)) {
      fail(fmt::format("{}/{}", pointer, core.type),
           fmt::format("zfar {} is not above znear {}", camera.zfar, camera.znear), "CAMERA_ZFAR_LEQUAL_ZNEAR");
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
      if (spot == object.end()) fail(pointer, "a spot light without 'spot'", "UNDEFINED_PROPERTY");
      light.inner_cone_rad = static_cast<float>(number_or(*spot, "innerConeAngle", 0.0));
      light.outer_cone_rad = static_cast<float>(number_or(*spot, "outerConeAngle", kPi / 4.0));
      if (!(light.outer_cone_rad > light.inner_cone_rad)) {
        fail(
            pointer + "/spot",
            fmt::format("outerConeAngle {} is not above innerConeAngle {}", light.outer_cone_rad, light.inner_cone_rad),
            "KHR_LIGHTS_PUNCTUAL_LIGHT_SPOT_ANGLES");
      }
    }
    scene.lights.push_back(std::move(light));
  }
}

} // namespace kindling::gltf
