// Lists the lights of a set one by one, and finds parallelograms among its meshes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/light/per_light_sampling.h"

#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

namespace kindling {

namespace {

template <typename Triangle>
const V3f& corner(const Triangle& t, int i) {
  return i == 0 ? t.p0 : i == 1 ? t.p1 : t.p2;
}

} // namespace

PerLightSampling::PerLightSampling(const LightSet& set) : set_(set) {
  lights = &set;
  std::vector<Entry> listed;
  std::vector<double> written_sums(set.triangles.size());
  for (const EmissiveMesh& mesh : set.meshes_)
    if (const std::optional<Entry> entry =
            mesh_entry(mesh, static_cast<uint32_t>(&mesh - set.meshes_.data()), written_sums))
      listed.push_back(*entry);
  for (size_t i = 0; i < set.punctuals.size(); ++i)
    if (set.punctuals[i].luminance > 0.0f)
      listed.push_back({.kind = Kind::punctual, .first = static_cast<uint32_t>(i)});
  if (set.has_environment) listed.push_back({.kind = Kind::environment});
  entries = arrays_.keep(std::move(listed));
  sums = arrays_.keep(std::move(written_sums));
}

std::optional<PerLightView::Entry> PerLightSampling::mesh_entry(const EmissiveMesh& mesh, uint32_t number,
                                                                std::span<double> written_sums) const {
  double sum = 0.0;
  for (uint32_t i = mesh.first; i < mesh.first + mesh.count; ++i) {
    const double weight = static_cast<double>(double_area_normal(set_.triangles[i]).length()) *
                          static_cast<double>(luminance(set_.mean_emission(i)));
    if (weight > 0.0 && std::isfinite(weight)) sum += weight;
    written_sums[i] = sum;
  }
  if (!(sum > 0.0)) return std::nullopt;
  Entry entry{.kind = Kind::mesh, .first = mesh.first, .count = mesh.count, .name = number};
  if (mesh.count == 2 && set_.triangles[mesh.first].emission == set_.triangles[mesh.first + 1].emission) {
    const auto& a = set_.triangles[mesh.first];
    const auto& b = set_.triangles[mesh.first + 1];
    const float size = std::sqrt(double_area_normal(a).length());
    const bool same_side = double_area_normal(a).dot(double_area_normal(b)) > 0.0f;
    for (int apex = 0; apex < 3 && same_side; ++apex) {
      const int s0 = (apex + 1) % 3, s1 = (apex + 2) % 3;
      const V3f opposite = corner(a, s0) + corner(a, s1) - corner(a, apex);
      for (int other = 0; other < 3; ++other) {
        // The winding is equal, so the shared side runs in the opposite direction.
        const int t0 = (other + 2) % 3, t1 = (other + 1) % 3;
        if (corner(a, s0) != corner(b, t0) || corner(a, s1) != corner(b, t1)) continue;
        if ((corner(b, other) - opposite).length() > 1e-5f * size || set_.moves(mesh.first)) continue;
        entry.is_parallelogram = true;
        entry.parallelogram = {static_cast<uint8_t>(apex), static_cast<uint8_t>(s0), static_cast<uint8_t>(s1),
                               static_cast<uint8_t>(t0),   static_cast<uint8_t>(t1), static_cast<uint8_t>(other)};
      }
    }
  }
  return entry;
}

std::string_view PerLightSampling::name(size_t light) const {
  assert(light < entries.size());
  const Entry& entry = entries[light];
  switch (entry.kind) {
  case Kind::mesh: return set_.meshes_[entry.name].name;
  case Kind::punctual: return set_.punctual_names_[entry.first];
  case Kind::environment: break;
  }
  return "environment";
}

} // namespace kindling
