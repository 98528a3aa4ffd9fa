// Names of the treatments of caustics, and the parameters that they change.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/caustics.h"

#include "renderer/base/elementary.h"

#include <array>
#include <cassert>
#include <cmath>
#include <utility>

namespace kindling {
namespace {

constexpr std::array<std::pair<Caustics, std::string_view>, 3> kCausticsNames{
    {{Caustics::full, "full"}, {Caustics::regularized, "regularized"}, {Caustics::off, "off"}}};

} // namespace

std::string_view caustics_name(Caustics caustics) {
  for (const auto& [value, name] : kCausticsNames)
    if (value == caustics) return name;
  return "unknown";
}

std::optional<Caustics> caustics_from_name(std::string_view name) {
  for (const auto& [value, known] : kCausticsNames)
    if (known == name) return value;
  return std::nullopt;
}

float regularized_alpha(float widest, uint32_t sample_index) {
  assert(widest >= 0.0f && widest <= 1.0f);
  return 0.3f * widest * elementary::pow(static_cast<float>(sample_index) + 1.0f, -1.0f / 6.0f);
}

void regularize_caustics(Caustics caustics, bool after_diffuse, const WidestLobe& widest, uint32_t sample_index,
                         BsdfParameters& parameters) {
  switch (caustics) {
  case Caustics::full: return;
  case Caustics::regularized:
    parameters.roughness = std::max(parameters.roughness, std::sqrt(regularized_alpha(widest.alpha(), sample_index)));
    return;
  case Caustics::off:
    if (!after_diffuse) return;
    parameters.base_color *= 1.0f - std::clamp(parameters.metallic, 0.0f, 1.0f);
    parameters.metallic = 0.0f;
    parameters.specular = 0.0f;
    return;
  }
}

void regularize_caustics(Caustics caustics, bool after_diffuse, const WidestLobe& widest, uint32_t sample_index,
                         bool thin_wall, BsdfParameters& parameters, LayerParameters& layers) {
  switch (caustics) {
  case Caustics::full: return;
  case Caustics::regularized:
    layers.clearcoat_roughness =
        std::max(layers.clearcoat_roughness, std::sqrt(regularized_alpha(widest.alpha(), sample_index)));
    if (thin_wall) return; // if widened, it would no longer transmit light in a straight line
    break;
  case Caustics::off:
    if (!after_diffuse) return;
    layers.clearcoat = 0.0f;
    layers.iridescence = 0.0f;
    if (!thin_wall) { // refracted light is absorbed
      parameters.base_color *= 1.0f - layers.transmission;
      layers.transmission = 0.0f;
    }
    break;
  }
  regularize_caustics(caustics, after_diffuse, widest, sample_index, parameters);
}

} // namespace kindling
