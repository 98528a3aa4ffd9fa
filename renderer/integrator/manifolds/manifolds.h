// Finds the glass and the lamps of a scene that manifold sampling joins.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/integrator/integrator_settings.h"
#include "renderer/integrator/manifolds/manifold_view.h"
#include "renderer/world/world.h"

#include <memory>
#include <vector>

namespace kindling {

// Owns the arrays of its view.
class Manifolds : public ManifoldView {
 public:
  explicit Manifolds(const World& world);
  Manifolds(const Manifolds&) = delete;
  Manifolds& operator=(const Manifolds&) = delete;

 private:
  std::vector<EmissionTarget> all_targets_;
  std::vector<uint32_t> all_lamps_;
};

// Returns null without manifold samples, and where the scene has no smooth glass or no such lamp.
[[nodiscard]] std::unique_ptr<const Manifolds> make_manifolds(const IntegratorSettings& settings, const World& world);

} // namespace kindling
