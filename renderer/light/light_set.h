// All lights of a World.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/owned_arrays.h"
#include "renderer/light/light_set_view.h"

#include <memory>
#include <span>
#include <string>
#include <vector>

namespace kindling {

// Immutable, thread-safe, without allocation after construction.
class LightSet : public LightSetView {
 public:
  explicit LightSet(LightSetInput input);

  // Replaces the environment; null removes it. The lights are then those of a set that was built
  // with it, to the bit.
  void set_environment(std::shared_ptr<const Environment> light);

  [[nodiscard]] size_t memory_bytes() const;

  [[nodiscard]] std::span<const EmissiveMesh> meshes() const { return meshes_; }
  [[nodiscard]] const std::string& punctual_name(size_t number) const { return punctual_names_[number]; }
  // Returns the `source` of the input's light; `number` is an index into punctuals,
  // as for punctual_name().
  [[nodiscard]] uint32_t punctual_source(size_t number) const { return punctual_sources_[number]; }

 private:
  friend class PerLightSampling;

  void add_punctuals(const LightSetInput& input);
  void prepare_shapes(std::span<Punctual> lights);
  [[nodiscard]] EmitterBounds punctual_bounds(const Punctual& light) const;
  [[nodiscard]] EmitterBounds moving_bounds(uint32_t index) const;
  // Returns the mean emission of a triangle over its area.
  [[nodiscard]] Rgb mean_emission(uint32_t index) const;

  OwnedArrays arrays_;
  LightTree stored_tree_;
  SphereTree stored_spheres_;
  std::shared_ptr<const Environment> stored_environment_;
  std::vector<EmissiveMesh> meshes_;
  std::vector<std::string> punctual_names_;
  std::vector<uint32_t> punctual_sources_;
  size_t kind_count_ = 0; // the tree, each directional light twice, and the environment
};

} // namespace kindling
