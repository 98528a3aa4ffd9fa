// Per-light sampling: the lights of a LightSet one by one, for tracers that sample every light.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/owned_arrays.h"
#include "renderer/light/light_set.h"

#include <optional>
#include <span>
#include <string_view>

namespace kindling {

// The lights as sampling reads them.
struct PerLightView {
  enum class Kind : uint8_t { mesh, punctual, environment };
  // Two triangles as one: points are apex + x (s0 - apex) + y (s1 - apex), x and y in [0, 1].
  struct Parallelogram {
    uint8_t apex, s0, s1;  // corners of the first triangle
    uint8_t t0, t1, other; // of the second: s0, s1 and the corner opposite of the apex
  };
  struct Entry {
    Kind kind = Kind::mesh;
    uint32_t first = 0; // triangle, or index among the punctual lights
    uint32_t count = 0; // triangles
    bool is_parallelogram = false;
    Parallelogram parallelogram{};
    uint32_t name = 0; // index of the mesh
  };
  // A point on a triangle of the LightSet.
  struct OnTriangle {
    uint32_t triangle = 0;
    V2f barycentrics;
    float pdf = 0.0f; // by area
  };

  [[nodiscard]] size_t count() const { return entries.size(); }
  // True if all samples from one point are equal, so that one suffices.
  [[nodiscard]] bool is_delta(size_t light) const;
  // Samples a direction to this light from `point`; `light` is below count(). LightSample::pdf is
  // of this light alone. u in [0, 1)^2; n x n strata of u map to strata of the light. A mesh of two
  // triangles that form a parallelogram is sampled uniformly by area with u along its sides. In
  // other meshes u.x selects the triangle, in file order and in proportion to area times mean
  // emission, and the point is uniform by area within it. Empty: dark from here, or below the
  // horizon of `normal` (unit; zero: none).
  [[nodiscard]] std::optional<LightSample> sample(size_t light, const V3f& point, const V3f& normal, const V2f& u,
                                                  float time = 0.0f) const;

  [[nodiscard]] OnTriangle choose_point(const Entry& entry, const V2f& u) const;
  [[nodiscard]] std::optional<LightSample> sample_mesh(const Entry& entry, const V3f& point, const V2f& u,
                                                       float time) const;

  const LightSetView* lights = nullptr;
  std::span<const Entry> entries;
  // Inclusive prefix sums of the triangle weights of each mesh, by index of the triangle.
  std::span<const double> sums;
};

// The order is: emissive meshes of LightSetInput::meshes, then point, spot, profiled and
// directional lights, then the environment. Lights without power are omitted. Immutable,
// thread-safe, without allocation after construction; borrows the LightSet.
class PerLightSampling : public PerLightView {
 public:
  explicit PerLightSampling(const LightSet& set);

  // Returns the name in the scene; may be empty.
  [[nodiscard]] std::string_view name(size_t light) const;

 private:
  // Writes the sums of the mesh's triangles. Returns nothing for a mesh without power.
  [[nodiscard]] std::optional<Entry> mesh_entry(const EmissiveMesh& mesh, uint32_t number,
                                                std::span<double> written_sums) const;

  const LightSet& set_;
  OwnedArrays arrays_;
};

} // namespace kindling
