// Typed values and texture slots from a material's JSON.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/materials/material_values.h"

#include "renderer/import/json/extensions.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <limits>

namespace kindling::gltf {
namespace {

constexpr int kWrong = -2; // an invalid index; import_procedurals() reports it

}

using nlohmann::json;

const json* member(const json& object, const char* name) {
  const auto found = object.find(name);
  return found == object.end() ? nullptr : &*found;
}

float float_or(const json& object, const char* name, float fallback) {
  const json* value = member(object, name);
  return value == nullptr ? fallback : static_cast<float>(value->get<double>());
}

Rgb rgb_or(const json& object, const char* name, const Rgb& fallback) {
  const json* values = member(object, name);
  if (values == nullptr) return fallback;
  return {(*values)[0].get<float>(), (*values)[1].get<float>(), (*values)[2].get<float>()};
}

TextureSlot texture_slot(const json& object, const char* name) {
  TextureSlot slot;
  const json* info = member(object, name);
  if (info == nullptr) return slot;
  slot.texture = static_cast<int>((*info)["index"].get<int64_t>());
  slot.texcoord = static_cast<int>(integer_or(*info, "texCoord", 0));
  if (const json* transform = find_extension(*info, "KHR_texture_transform")) {
    const auto pair = [&](const char* key, V2f fallback) {
      const json* values = member(*transform, key);
      return values == nullptr ? fallback : V2f((*values)[0].get<float>(), (*values)[1].get<float>());
    };
    slot.offset = pair("offset", V2f(0.0f, 0.0f));
    slot.scale = pair("scale", V2f(1.0f, 1.0f));
    slot.rotation_rad = float_or(*transform, "rotation", 0.0f);
    slot.texcoord = static_cast<int>(integer_or(*transform, "texCoord", slot.texcoord));
  }
  if (const json* procedural = find_extension(*info, "KHR_texture_procedurals")) {
    const auto index = [&](const char* key, int absent) {
      const json* value = procedural->is_object() ? member(*procedural, key) : nullptr;
      if (value == nullptr) return absent;
      return value->is_number_integer() && value->get<int64_t>() >= 0
                 ? static_cast<int>(std::min<int64_t>(value->get<int64_t>(), std::numeric_limits<int>::max()))
                 : kWrong;
    };
    slot.procedural = index("index", kWrong);
    slot.procedural_output = index("output", kNone);
  }
  return slot;
}

} // namespace kindling::gltf
