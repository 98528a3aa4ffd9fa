// Finds nodes by their unique names, and all below them.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/choose_catchers.h"

#include "renderer/base/text.h"
#include "renderer/scene/animated_nodes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

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

Result<std::vector<uint8_t>> choose_catchers(const RenderScene& scene, const std::vector<std::string>& names) {
  if (names.empty()) return std::vector<uint8_t>();
  assert(scene.names);
  const std::vector<std::string>& known = scene.names->nodes;
  std::vector<uint8_t> flags(known.size(), 0);
  std::vector<int> chosen;
  for (const std::string& name : names) {
    const auto found = std::find(known.begin(), known.end(), name);
    if (found == known.end())
      return usage_error(fmt::format("--shadow-catcher: {} has no object '{}'; use {}", scene.source, name,
                                     list_objects(*scene.names)));
    chosen.push_back(static_cast<int>(found - known.begin()));
  }
  walk_nodes(scene.scene, chosen, [&](int node, int /*parent*/) { flags[static_cast<size_t>(node)] = 1; });
  return flags;
}

} // namespace kindling
