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

  template <size_t kCount>
  [[nodiscard]] std::optional<std::array<size_t, kCount>> all(const std::array<const char*, kCount>& components) const {
    std::array<size_t, kCount> found{};
    for (size_t i = 0; i < kCount; ++i) {
      const auto channel = channels.find(components[i]);
      if (channel == channels.end()) return std::nullopt;
      found[i] = channel->second;
    }
    return found;
  }
  [[nodiscard]] std::optional<ThreeChannels> rgb() const { return all<3>({"r", "g", "b"}); }
  [[nodiscard]] std::optional<ThreeChannels> rgb_or_xyz() const {
    const std::optional<ThreeChannels> colors = rgb();
    return colors ? colors : all<3>({"x", "y", "z"});
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

// The layers of motion, which have no other name in any program.
void find_motion_layers(const std::map<std::string, NamedLayer>& layers, DenoisableLayers& found) {
  const NamedLayer* forward = nullptr;
  const NamedLayer* backward = nullptr;
  for (const auto& [whole, layer] : layers) {
    if (layer.name == "vector" && !found.vector) found.vector = layer.all<4>({"x", "y", "z", "w"});
    if (layer.name == "forward") forward = &layer;
    if (layer.name == "backward") backward = &layer;
    if (layer.name == "kindling" && layer.channels.contains("samples")) found.samples = layer.channels.at("samples");
  }
  if (forward == nullptr || backward == nullptr) return;
  const auto next = forward->all<2>({"u", "v"}), previous = backward->all<2>({"u", "v"});
  if (next && previous) found.forward_backward = {(*next)[0], (*next)[1], (*previous)[0], (*previous)[1]};
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
  find_motion_layers(layers, found);
  return found;
}

std::vector<float> interleave(const ExrImage& image, const ThreeChannels& channels) {
  const size_t count = image.layers[channels[0]].values.size();
  std::vector<float> values(3 * count);
  for (size_t c = 0; c < 3; ++c)
    for (size_t i = 0; i < count; ++i) values[3 * i + c] = image.layers[channels[c]].values[i];
  return values;
}

std::vector<float> find_motion(const ExrImage& image, const DenoisableLayers& layers) {
  if (!layers.vector && !layers.forward_backward) return {};
  const std::array<size_t, 4>& of = layers.vector ? *layers.vector : *layers.forward_backward;
  const size_t count = image.layers[of[0]].values.size();
  std::vector<float> motion(4 * count);
  for (size_t i = 0; i < count; ++i)
    for (size_t c = 0; c < 4; ++c) {
      const float value = image.layers[of[c]].values[i];
      if (layers.vector)
        motion[4 * i + c] = value;
      else
        motion[4 * i + (c + 2) % 4] = c < 2 ? -value : value; // forward is the way to the next frame
    }
  return motion;
}

} // namespace kindling::app
