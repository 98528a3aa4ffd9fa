// Compares names of channels.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/denoise/exr_layers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <map>
#include <string_view>

namespace kindling::app {

namespace {

std::string lower(std::string_view text) {
  std::string result(text);
  for (char& c : result) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return result;
}

// The channels of a layer, by component.
struct NamedLayer {
  std::string name; // the last part, in lower case; empty for R, G, B
  std::map<std::string, size_t> channels;

  [[nodiscard]] std::optional<ThreeChannels> three(const std::array<const char*, 3>& components) const {
    ThreeChannels found{};
    for (size_t i = 0; i < 3; ++i) {
      const auto channel = channels.find(components[i]);
      if (channel == channels.end()) return std::nullopt;
      found[i] = channel->second;
    }
    return found;
  }
  [[nodiscard]] std::optional<ThreeChannels> rgb() const { return three({"r", "g", "b"}); }
  [[nodiscard]] std::optional<ThreeChannels> rgb_or_xyz() const {
    const std::optional<ThreeChannels> colors = rgb();
    return colors ? colors : three({"x", "y", "z"});
  }
};

// Returns layers by their whole names.
std::map<std::string, NamedLayer> layers_of(const ExrImage& image) {
  std::map<std::string, NamedLayer> layers;
  for (size_t i = 0; i < image.layers.size(); ++i) {
    const std::string& channel = image.layers[i].channel_names.front();
    const size_t dot = channel.rfind('.');
    const std::string whole = dot == std::string::npos ? "" : channel.substr(0, dot);
    NamedLayer& layer = layers[whole];
    layer.name = lower(whole.substr(whole.rfind('.') + 1)); // npos + 1 is 0
    layer.channels[lower(channel.substr(dot + 1))] = i;
  }
  return layers;
}

constexpr std::array<std::string_view, 5> kAlbedos{"denoising_albedo", "denoising albedo", "denoisealbedo",
                                                   "denoise_albedo", "albedo"};
constexpr std::array<std::string_view, 7> kNormals{
    "denoising_normal", "denoising normal", "denoisenormal", "normal", "sh_normal", "ns", "n"};

// Returns the first layer with the earliest of these names.
template <size_t kCount>
std::optional<ThreeChannels> find_named(const std::map<std::string, NamedLayer>& layers,
                                        const std::array<std::string_view, kCount>& names) {
  for (const std::string_view name : names)
    for (const auto& [whole, layer] : layers)
      if (layer.name == name)
        if (const std::optional<ThreeChannels> found = layer.rgb_or_xyz()) return found;
  return std::nullopt;
}

} // namespace

Result<DenoisableLayers> find_layers(const ExrImage& image) {
  const std::map<std::string, NamedLayer> layers = layers_of(image);
  std::vector<const NamedLayer*> colors;
  if (const auto plain = layers.find(""); plain != layers.end() && plain->second.rgb())
    colors.push_back(&plain->second);
  else
    for (const auto& [whole, layer] : layers)
      if (layer.name == "combined" && layer.rgb()) colors.push_back(&layer);
  if (colors.size() != 1)
    return usage_error(fmt::format("{}; use an image with the channels R, G and B",
                                   colors.empty() ? "it has no layer of color" : "it has several layers 'Combined'"));
  DenoisableLayers found;
  found.color = *colors.front()->rgb();
  if (const auto alpha = colors.front()->channels.find("a"); alpha != colors.front()->channels.end())
    found.alpha = alpha->second;
  if (const auto noisy = layers.find("noisy"); noisy != layers.end()) found.noisy = noisy->second.rgb();
  found.albedo = find_named(layers, kAlbedos);
  found.normal = find_named(layers, kNormals);
  return found;
}

std::vector<float> interleave(const ExrImage& image, const ThreeChannels& channels) {
  const size_t count = image.layers[channels[0]].values.size();
  std::vector<float> values(3 * count);
  for (size_t c = 0; c < 3; ++c)
    for (size_t i = 0; i < count; ++i) values[3 * i + c] = image.layers[channels[c]].values[i];
  return values;
}

} // namespace kindling::app
