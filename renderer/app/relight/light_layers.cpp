// Names of channels, and sums of layers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/relight/light_layers.h"

#include "renderer/app/flags/scene_flags.h"
#include "renderer/film/write_film.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <string_view>

namespace kindling::app {
namespace {

// "View Layer.Combined_key.R" is the component R of the layer Combined_key.
struct ChannelName {
  std::string_view layer, component; // the layer is empty for "R"
};

ChannelName split(std::string_view channel) {
  const size_t dot = channel.rfind('.');
  if (dot == std::string_view::npos) return {"", channel};
  const std::string_view whole = channel.substr(0, dot);
  return {whole.substr(whole.rfind('.') + 1), channel.substr(dot + 1)}; // npos + 1 is 0
}

std::string_view name_of(const ExrLayer& layer) { return layer.channel_names.front(); }

constexpr std::array<std::string_view, 18> kLightLayers{
    "noisy",    "variance", "emission",  "direct",    "indirect", "DiffDir", "DiffInd", "GlossDir", "GlossInd",
    "TransDir", "TransInd", "VolumeDir", "VolumeInd", "Emit",     "Env",     "AO",      "Shadow",   "Noisy Image"};

bool is_obsolete(const ExrLayer& layer) {
  const auto [name, component] = split(name_of(layer));
  const std::string_view own = name.empty() || component == "variance" ? component : name; // kindling.variance
  return std::find(kLightLayers.begin(), kLightLayers.end(), own) != kLightLayers.end();
}

} // namespace

std::vector<LightLayer> find_light_layers(const ExrImage& image) {
  std::vector<std::string> order;
  std::map<std::string, std::array<std::optional<size_t>, 3>, std::less<>> found;
  for (size_t i = 0; i < image.layers.size(); ++i) {
    const auto [layer, component] = split(name_of(image.layers[i]));
    if (!layer.starts_with(kLightGroupLayer) || layer.size() == kLightGroupLayer.size()) continue;
    const size_t c = component == "R" ? 0 : component == "G" ? 1 : component == "B" ? 2 : 3;
    if (c == 3) continue;
    const std::string group(layer.substr(kLightGroupLayer.size()));
    if (!found.contains(group)) order.push_back(group);
    found[group][c] = i;
  }
  std::vector<LightLayer> layers;
  for (const std::string& group : order) {
    const auto& [r, g, b] = found[group];
    if (r && g && b) layers.push_back({group, {*r, *g, *b}});
  }
  return layers;
}

Result<std::vector<Rgb>> factors_of(const std::vector<LightLayer>& layers, const std::vector<LightFactor>& wanted,
                                    const Rgb& others) {
  std::vector<std::string> names;
  for (const LightLayer& layer : layers) names.push_back(layer.group);
  std::vector<Rgb> factors(layers.size(), others);
  for (const LightFactor& factor : wanted) {
    const auto found = std::find(names.begin(), names.end(), factor.group);
    if (found == names.end()) {
      Error error = unknown_name("light group", factor.group, names);
      error.message = "--group: " + error.message;
      return error;
    }
    factors[static_cast<size_t>(found - names.begin())] = factor.factor;
  }
  return factors;
}

void relight(ExrImage& image, const ThreeChannels& color, const std::vector<LightLayer>& layers,
             const std::vector<Rgb>& factors) {
  if (std::all_of(factors.begin(), factors.end(), [](const Rgb& f) { return f == Rgb(1.0f); })) return;
  for (size_t c = 0; c < 3; ++c) {
    std::vector<float>& sums = image.layers[color[c]].values;
    tbb::parallel_for(tbb::blocked_range<size_t>(0, sums.size(), 4096), [&](const tbb::blocked_range<size_t>& range) {
      for (size_t i = range.begin(); i != range.end(); ++i) {
        double sum = 0.0;
        for (size_t g = 0; g < layers.size(); ++g) {
          float& value = image.layers[layers[g].channels[c]].values[i];
          const double scaled = static_cast<double>(factors[g][static_cast<int>(c)]) * static_cast<double>(value);
          value = static_cast<float>(scaled);
          sum += scaled;
        }
        sums[i] = static_cast<float>(sum);
      }
    });
  }
  std::erase_if(image.layers, is_obsolete);
}

} // namespace kindling::app
