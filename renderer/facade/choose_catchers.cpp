// Finds nodes by their unique names, and nodes and materials that the file marks.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/choose_catchers.h"

#include "renderer/base/text.h"
#include "renderer/scene/animated_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <string>
#include <utility>
#include <vector>

namespace kindling {
namespace {

// Returns the names of the first nodes with a mesh, of at most ten.
std::string list_objects(const SurfaceNames& names) {
  constexpr size_t kMax = 10;
  std::vector<std::string> choices;
  size_t count = 0;
  for (size_t i = 0; i < names.nodes.size(); ++i)
    if (names.has_mesh[i] != 0 && count++ < kMax) choices.push_back(names.nodes[i]);
  if (count > kMax) choices.push_back(fmt::format("another of the {}", count));
  return join_choices(choices);
}

} // namespace

Result<std::optional<CatcherFlags>> choose_catchers(const RenderScene& scene, const ImageSettings& image) {
  if (!image.has_shadow_catchers()) return std::optional<CatcherFlags>();
  std::vector<int> chosen;
  for (const std::string& name : image.shadow_catchers) {
    assert(scene.names);
    const std::vector<std::string>& known = scene.names->nodes;
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end())
      return usage_error(fmt::format("--shadow-catcher: {} has no object '{}'; use {}", scene.source, name,
                                     list_objects(*scene.names)));
    chosen.push_back(static_cast<int>(found - known.begin()));
  }
  CatcherFlags flags{std::vector<uint8_t>(scene.scene.nodes.size(), 0), {}};
  if (image.shadow_catchers_of_file) {
    bool any = false;
    for (size_t i = 0; i < scene.scene.nodes.size(); ++i) {
      if (!scene.scene.nodes[i].shadow_catcher) continue;
      chosen.push_back(static_cast<int>(i));
      any = true;
    }
    for (const Material& material : scene.scene.materials) {
      flags.materials.push_back(material.shadow_catcher ? 1 : 0);
      any = any || material.shadow_catcher;
    }
    if (!any)
      return usage_error(fmt::format("--shadow-catchers: no node or material of {} has the extras "
                                     "{{\"kindling\": {{\"shadowCatcher\": true}}}}; name a node with --shadow-catcher",
                                     scene.source));
  }
  walk_nodes(scene.scene, chosen, [&](int node, int /*parent*/) { flags.nodes[static_cast<size_t>(node)] = 1; });
  return std::optional(std::move(flags));
}

} // namespace kindling
