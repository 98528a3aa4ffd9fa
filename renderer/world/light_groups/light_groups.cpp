// Names the group of each light, material and node.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/light_groups/light_groups.h"

#include <algorithm>
#include <map>
#include <string_view>

namespace kindling {
namespace {

constexpr std::string_view kEnvironment = "environment";
constexpr std::string_view kRest = "rest";

// Layers of EXR files end at a dot.
std::string as_group_name(std::string_view name, std::string_view otherwise) {
  std::string result(name.empty() ? otherwise : name);
  for (char& c : result)
    if (c == '.' || static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = '_';
  return result;
}

class LightGroupsBuilder {
 public:
  LightGroupsBuilder(const World& world, LightGrouping grouping) : world_(world), grouping_(grouping) {}

  Result<LightGroups> build(bool has_background) {
    if (world_.lights.has_environment || has_background) groups_.environment = number_of(std::string(kEnvironment));
    add_punctuals();
    add_surfaces();
    add_emitters();
    if (groups_.names.empty()) number_of(std::string(kEnvironment)); // nothing shines
    if (groups_.names.size() > kMaxLightGroups)
      return Error{ErrorKind::usage, "--light-groups: " + std::to_string(groups_.names.size()) + " groups by " +
                                         std::string(light_grouping_name(grouping_)) + " found; use at most " +
                                         std::to_string(kMaxLightGroups) + ", or kind"};
    return std::move(groups_);
  }

 private:
  // Wraps beyond 256 groups, which build() refuses.
  uint8_t number_of(std::string name) {
    const auto [entry, inserted] = numbers_.try_emplace(name, groups_.names.size());
    if (inserted) groups_.names.push_back(std::move(name));
    return static_cast<uint8_t>(entry->second);
  }

  // Suns come before other lights.
  void add_punctuals() {
    punctuals_.resize(world_.lights.punctuals.size());
    for (const bool sun : {true, false})
      for (size_t i = 0; i < punctuals_.size(); ++i)
        if ((i >= world_.lights.first_directional) == sun) punctuals_[i] = number_of(punctual_name(i, sun));
  }
  [[nodiscard]] std::string punctual_name(size_t number, bool sun) const {
    switch (grouping_) {
    case LightGrouping::name: return as_group_name(world_.light_set().punctual_name(number), "light");
    case LightGrouping::extras: return as_group_name(world_.file_light_groups().of_punctual(number), kRest);
    default: return sun ? "suns" : "lights";
    }
  }

  // Materials that no ray can find shining stay in the first group.
  void add_surfaces() {
    groups_.of_material.assign(world_.materials.size(), 0);
    std::vector<bool> used(world_.materials.size(), false);
    for (const GeometryView& geometry : world_.geometries)
      used[geometry.material] = used[geometry.material] || shines(geometry);
    for (size_t i = 0; i < used.size(); ++i)
      if (used[i]) groups_.of_material[i] = number_of(material_name(static_cast<uint32_t>(i)));
    if (grouping_ != LightGrouping::extras) return;
    const std::vector<std::string>& of_node = world_.file_light_groups().nodes;
    groups_.of_node.assign(of_node.size(), LightGroupsView::kByMaterial);
    for (size_t i = 0; i < of_node.size(); ++i)
      if (!of_node[i].empty()) groups_.of_node[i] = number_of(as_group_name(of_node[i], kRest));
  }
  [[nodiscard]] bool shines(const GeometryView& geometry) const {
    const ShadingMaterial& material = world_.materials[geometry.material];
    return material.emissive || material.unlit || geometry.stroke == Stroke::unlit;
  }
  [[nodiscard]] std::string material_name(uint32_t material) const {
    switch (grouping_) {
    case LightGrouping::name: return as_group_name(world_.material_name(material), "emissive");
    case LightGrouping::extras: return as_group_name(world_.file_light_groups().of_material(material), kRest);
    default: return "emissive";
    }
  }

  void add_emitters() {
    groups_.of_emitter.assign(world_.lights.triangles.size(), 0);
    for (const EmissiveMesh& mesh : world_.light_set().meshes())
      std::fill_n(groups_.of_emitter.begin() + mesh.first, mesh.count,
                  groups_.view().of_surface(mesh.node, mesh.material));
    groups_.of_emitter.insert(groups_.of_emitter.end(), punctuals_.begin(), punctuals_.end());
  }

  const World& world_;
  LightGrouping grouping_;
  LightGroups groups_;
  std::map<std::string, size_t> numbers_; // by name
  std::vector<uint8_t> punctuals_;
};

} // namespace

Result<LightGroups> make_light_groups(const World& world, LightGrouping grouping, bool has_background) {
  if (grouping == LightGrouping::off) return LightGroups{};
  return LightGroupsBuilder(world, grouping).build(has_background);
}

} // namespace kindling
