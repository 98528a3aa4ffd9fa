// The World: the prepared, immutable scene.
// Rays are traced by its accelerator; hits become surfaces ready to shade.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "accel/accelerator.h"
#include "renderer/base/owned_arrays.h"
#include "renderer/base/stopwatch.h"
#include "renderer/light/light_set.h"
#include "renderer/world/surface_nodes.h"
#include "renderer/world/world_view.h"

#include <atomic>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Statistics of motion while the shutter is open.
struct MotionStatistics {
  size_t moving_instance_count = 0;
  size_t deforming_mesh_count = 0;
  size_t max_keys = 0;  // maximum over all objects
  size_t key_bytes = 0; // matrices, and vertices after the opening
};

// Times of the build steps.
struct BuildTimes {
  WorkTime textures; // texture levels
  WorkTime geometry; // vertex packing
  WorkTime lights;   // collection and light tree
  WorkTime accelerator;
};

struct WorldStatistics {
  double build_s = 0.0;
  BuildTimes times; // of the steps
  size_t geometry_bytes = 0;
  size_t texture_bytes = 0;
  size_t light_bytes = 0;
  size_t emissive_triangle_count = 0;
  MotionStatistics motion;
  accel::Statistics accelerator;
};

// The light groups that a file's extras name; empty where there is none.
struct FileLightGroups {
  std::vector<std::string> nodes;     // by index in Scene::nodes, inherited from its ancestors; empty: none has one
  std::vector<std::string> punctuals; // by index among LightSetView::punctuals, likewise
  std::vector<std::string> materials; // by material, likewise

  [[nodiscard]] std::string_view of_punctual(size_t number) const { return at(punctuals, number); }
  [[nodiscard]] std::string_view of_material(size_t material) const { return at(materials, material); }

 private:
  [[nodiscard]] static std::string_view at(const std::vector<std::string>& groups, size_t i) {
    return i < groups.size() ? std::string_view(groups[i]) : std::string_view();
  }
};

class World : public WorldView {
 public:
  World(const World&) = delete;
  World& operator=(const World&) = delete;

  // Returns the input of the accelerator: others can be built over the same geometry, as long as
  // the World lives.
  [[nodiscard]] accel::BuildInput accelerator_input() const {
    return {accel_meshes_,
            accel_groups_,
            accel::InstanceList(instances.data(), instances.size()),
            motions,
            {&World::accept_hit, this, abandon_}};
  }
  // True once WorldOptions::abandon is set: answers of queries mean nothing any more, and no sample
  // that may depend on them is used.
  [[nodiscard]] bool abandoned() const { return abandon_ != nullptr && abandon_->load(std::memory_order_relaxed); }
  // `lights` with the names of the lights.
  [[nodiscard]] const LightSet& light_set() const { return *light_set_; }
  // True if WorldOptions::studio is automatic and nothing but emissive surfaces lights the file's
  // scene: whether they suffice depends on the view (WorldSequence::light_by_studio()).
  [[nodiscard]] bool lit_by_emission_alone() const { return lit_by_emission_alone_; }

  [[nodiscard]] const std::string& material_name(uint32_t material) const { return material_names_[material]; }
  // Returns the index in Scene::nodes of the node whose mesh was hit.
  [[nodiscard]] int node_of(const accel::Hit& hit) const { return node_of(hit.mesh, hit.instance); }
  [[nodiscard]] int node_of(uint32_t mesh, uint32_t instance) const { return surface_nodes().node_of(mesh, instance); }
  [[nodiscard]] SurfaceNodes surface_nodes() const { return {baked_nodes_, instance_nodes_}; }
  [[nodiscard]] const FileLightGroups& file_light_groups() const { return file_light_groups_; }
  [[nodiscard]] const WorldStatistics& statistics() const { return statistics_; }

 private:
  friend class WorldBuilder;
  friend struct WorldChanges;
  World() = default;
  static bool accept_hit(const void* world, const accel::Ray& ray, const accel::Hit& candidate) {
    return static_cast<const World*>(world)->accepts(ray, candidate);
  }

  // The owners of what the view refers to.
  OwnedArrays arrays_;
  std::vector<Geometry> geometries_;
  std::vector<Texture> textures_;
  std::vector<ProceduralTexture> procedurals_;
  std::unique_ptr<LightSet> light_set_;
  std::unique_ptr<const Contacts> contacts_;
  std::unique_ptr<accel::Accelerator> accelerator_;

  const std::atomic<bool>* abandon_ = nullptr;
  bool lit_by_emission_alone_ = false;
  std::vector<std::string> material_names_;
  FileLightGroups file_light_groups_;
  std::vector<int> baked_nodes_;    // by geometry, of the first ones
  std::vector<int> instance_nodes_; // by instance
  std::vector<accel::TriangleMesh> accel_meshes_;
  std::vector<accel::MeshGroup> accel_groups_;
  WorldStatistics statistics_;
};

} // namespace kindling
