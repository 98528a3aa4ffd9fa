// Reads image-based lights, and decodes the first level of their cube maps to linear RGB.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/lights/image_lights.h"

#include "renderer/base/elementary.h"
#include "renderer/import/json/extensions.h"
#include "renderer/import/materials/textures.h"
#include "renderer/texture/srgb.h"

#include <fmt/format.h>
#include <half.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cfloat>
#include <cmath>
#include <cstring>

namespace kindling::gltf {
namespace {

using nlohmann::json;

constexpr const char* kImageLightsExtension = "EXT_lights_image_based";

std::string light_pointer(size_t light) {
  return fmt::format("/extensions/{}/lights/{}", kImageLightsExtension, light);
}

const json& lights_of(const Document& document) {
  static const json none = json::array();
  const json* extension = find_extension(*document.json, kImageLightsExtension);
  return extension == nullptr ? none : (*extension)["lights"];
}

// Returns the non-empty list at `name`, each entry a list of exactly `width` values that pass
// `accept`.
template <typename Accept>
const json& list_of_lists(const json& light, const char* name, size_t width, std::string_view what,
                          const std::string& pointer, const Accept& accept) {
  const auto found = light.find(name);
  if (found == light.end()) fail(pointer, fmt::format("no '{}'", name), "UNDEFINED_PROPERTY");
  const auto passes = [&](const json& list) {
    return list.is_array() && list.size() == width && std::all_of(list.begin(), list.end(), accept);
  };
  if (!found->is_array() || found->empty() || !std::all_of(found->begin(), found->end(), passes))
    fail(fmt::format("{}/{}", pointer, name), fmt::format("expected lists of {} {}", width, what), "TYPE_MISMATCH");
  return *found;
}

ImageLight read_light(const Document& document, const json& object, const std::string& pointer) {
  ImageLight light;
  light.name = object.value("name", "");
  light.intensity = static_cast<float>(number_or(object, "intensity", 1.0));
  if (const auto rotation = object.find("rotation"); rotation != object.end()) {
    const auto q = rotation->get<std::vector<float>>();
    light.rotation = Quatf(q[3], q[0], q[1], q[2]);
    if (!(light.rotation.length() > 1e-6f))
      fail(pointer + "/rotation", "a quaternion of length 0, expected length 1", "ROTATION_NON_UNIT");
    light.rotation.normalize();
  }
  const auto is_float = [](const json& value) {
    return value.is_number() && std::abs(value.get<double>()) <= static_cast<double>(FLT_MAX);
  };
  const json& coefficients = list_of_lists(object, "irradianceCoefficients", 3, "numbers", pointer, is_float);
  if (coefficients.size() != light.irradiance_coefficients.size())
    fail(pointer + "/irradianceCoefficients", fmt::format("{} coefficients, expected 9", coefficients.size()),
         "ARRAY_LENGTH_NOT_IN_LIST");
  for (size_t i = 0; i < coefficients.size(); ++i)
    light.irradiance_coefficients[i] = {coefficients[i][0].get<float>(), coefficients[i][1].get<float>(),
                                        coefficients[i][2].get<float>()};
  const size_t images = document.json->contains("images") ? (*document.json)["images"].size() : 0;
  const auto is_image = [&](const json& value) { return value.is_number_unsigned() && value.get<uint64_t>() < images; };
  static_cast<void>(list_of_lists(object, "specularImages", 6, fmt::format("images of {}", images), pointer, is_image));
  return light;
}

// Returns the image as linear RGB in floats.
Image linear_face(const Image& image) {
  Image face;
  face.width = image.width;
  face.height = image.height;
  face.channels = 3;
  face.type = PixelType::f32;
  face.pixels.resize(face.byte_count());
  const bool integers = image.type == PixelType::u8 || image.type == PixelType::u16;
  const bool rgbd = integers && image.channels == 4;
  const auto channels = static_cast<size_t>(image.channels);
  const size_t bytes = bytes_per_channel(image.type);
  const auto value = [&](size_t pixel, size_t channel) {
    const std::byte* at = image.pixels.data() + (pixel * channels + channel) * bytes;
    uint16_t half = 0;
    float number = 0.0f;
    switch (image.type) {
    case PixelType::u8: return static_cast<float>(std::to_integer<int>(*at)) / 255.0f;
    case PixelType::u16: std::memcpy(&half, at, sizeof half); return static_cast<float>(half) / 65535.0f;
    case PixelType::f16: std::memcpy(&half, at, sizeof half); return imath_half_to_float(half);
    case PixelType::f32: std::memcpy(&number, at, sizeof number); return number;
    }
    return number;
  };
  constexpr float kMinAlpha = 1.0f / 255.0f;
  const size_t count = static_cast<size_t>(image.width) * static_cast<size_t>(image.height);
  for (size_t pixel = 0; pixel < count; ++pixel) {
    float rgb[3];
    for (size_t c = 0; c < 3; ++c) {
      const float stored = value(pixel, channels < 3 ? 0 : c);
      rgb[c] = !integers ? stored
               : rgbd    ? elementary::pow(stored, 2.2f) / std::max(value(pixel, 3), kMinAlpha)
                         : static_cast<float>(decode_srgb(static_cast<double>(stored)));
    }
    std::memcpy(face.pixels.data() + pixel * sizeof rgb, rgb, sizeof rgb);
  }
  return face;
}

} // namespace

void import_image_lights(const Document& document, Scene& scene, Warnings& warnings) {
  const json& lights = lights_of(document);
  std::vector<bool> usable(lights.size(), true);
  for (size_t i = 0; i < lights.size(); ++i) {
    try {
      scene.image_lights.push_back(read_light(document, lights[i], light_pointer(i)));
    } catch (const ImportFailure& fault) {
      warnings.repair("image-based light", fault, "the light is not used");
      scene.image_lights.emplace_back();
      usable[i] = false;
    }
  }
  if (!document.json->contains("scenes")) return;
  const json& scenes = (*document.json)["scenes"];
  for (size_t i = 0; i < scenes.size(); ++i) {
    const json* extension = find_extension(scenes[i], kImageLightsExtension);
    if (extension == nullptr) continue;
    const auto index = (*extension)["light"].get<uint64_t>();
    if (index >= scene.image_lights.size()) {
      warnings.repair("scene light", fmt::format("/scenes/{}/extensions/{}/light", i, kImageLightsExtension),
                      fmt::format("{}, the file has {} image-based lights", index, scene.image_lights.size()),
                      "UNRESOLVED_REFERENCE", "the scene has no such light");
    } else if (usable[index]) {
      scene.scenes[i].image_light = static_cast<int>(index);
    }
  }
}

void import_image_light_faces(Document& document, Scene& scene, Warnings& warnings) {
  std::vector<bool> used(scene.image_lights.size(), false);
  for (const SceneRoot& root : scene.scenes)
    if (root.image_light != kNone) used[static_cast<size_t>(root.image_light)] = true;
  uint64_t bytes = 0;
  for (size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    ImageLight& light = scene.image_lights[i];
    const json& images = lights_of(document)[i]["specularImages"][0];
    const std::string pointer = light_pointer(i) + "/specularImages/0";
    std::string fault;
    for (size_t f = 0; f < light.faces.size() && fault.empty(); ++f) {
      const Result<Image> pixels = read_image(document, images[f].get<int>());
      if (!pixels) {
        fault = pixels.error().message;
        break;
      }
      const int size = pixels.value().width;
      if (size != pixels.value().height || (f > 0 && size != light.faces[0]->width)) {
        fault = fmt::format("face {} has {} x {} pixels, expected squares of one size", f, size, pixels.value().height);
        break;
      }
      light.faces[f] = std::make_shared<const Image>(linear_face(pixels.value()));
      bytes += light.faces[f]->byte_count();
      if (bytes > document.limits.max_texture_bytes)
        fail(pointer, fmt::format("the decoded images have more than {} bytes", document.limits.max_texture_bytes));
    }
    if (fault.empty()) continue;
    light.faces = {};
    warnings.add("image light", pointer, fmt::format("{}: only the coefficients of the light are used", fault));
  }
}

} // namespace kindling::gltf
