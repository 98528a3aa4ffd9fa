// Opacity micromaps from textures: levels, shared maps, and the texels under each micro-triangle.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/opacity/build_opacity.h"

#include "renderer/base/hash.h"
#include "renderer/world/opacity/alpha_classes.h"
#include "renderer/world/opacity/micro_triangles.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <bit>
#include <map>
#include <utility>

namespace kindling {
namespace {

using View = OpacityMicromapsView;

// The area of a micro-triangle in texels. It is multiplied by four until the budget suffices.
constexpr double kTexelsOfMicroTriangle = 16.0;

// Micro-triangles of all maps together: these, and two for each triangle.
constexpr size_t kMinBudget = size_t{1} << 19U;
constexpr size_t budget(size_t triangles) { return kMinBudget + 2 * triangles; }

// True if vertex colors leave alpha as it is.
bool has_opaque_colors(const GeometryView& geometry) {
  if (geometry.color_offset == GeometryView::kAbsent) return true;
  for (uint32_t v = 0; v < geometry.positions.size(); ++v)
    if (geometry.record(v)[geometry.color_offset + 3] != 1.0f) return false;
  return true;
}

bool is_opaque(const OpacityInput& input, const GeometryView& geometry) {
  const ShadingMaterial& material = input.materials[geometry.material];
  if (material.thin_wall) return false;
  if (material.alpha_mode == AlphaMode::opaque) return true;
  if (!has_opaque_colors(geometry)) return false;
  if (material.base_color.is_procedural()) {
    if (input.procedurals[static_cast<size_t>(material.base_color.procedural())].has_alpha()) return false;
  } else if (material.base_color.present() &&
             input.textures[static_cast<size_t>(material.base_color.texture)].has_alpha)
    return false;
  return material.alpha_mode == AlphaMode::mask ? material.base_color_factor.w >= material.alpha_cutoff
                                                : material.base_color_factor.w >= 1.0f;
}

// True if one image in memory decides the coverage.
bool has_micromaps(const OpacityInput& input, const GeometryView& geometry) {
  const ShadingMaterial& material = input.materials[geometry.material];
  if (material.thin_wall || material.alpha_mode == AlphaMode::opaque) return false;
  if (!material.base_color.present() || material.base_color.is_procedural()) return false;
  const TextureView& texture = input.textures[static_cast<size_t>(material.base_color.texture)];
  if (!texture.has_alpha || !texture.levels[0].pixels) return false;
  if (geometry.texcoord_offset[material.base_color.texcoord] == GeometryView::kAbsent) return false;
  const bool colored = geometry.color_offset != GeometryView::kAbsent;
  return !colored || (material.alpha_mode == AlphaMode::mask && has_opaque_colors(geometry));
}

AlphaTest test_of(const ShadingMaterial& material) {
  return {material.alpha_mode, material.base_color_factor.w, material.alpha_cutoff};
}

// A map that is made, for all triangles with the same texture coordinates: that of the first one.
struct Job {
  uint32_t mesh = 0;
  uint32_t triangle = 0;
  int level = 0;
  uint32_t first_word = 0;
};

using Coordinates = std::array<float, 6>;

// The maps of one material so far. Where many triangles have the same coordinates, as cards of
// leaves have, few are made; a map that was pushed out of this table is made once more.
class SharedMaps {
 public:
  // Returns the number of the map with these coordinates; `next` if there is none, which it
  // becomes.
  uint32_t find(const Coordinates& coordinates, uint32_t next) {
    uint32_t hash = 0;
    for (const float c : coordinates) hash = hash_combine(hash, std::bit_cast<uint32_t>(c));
    Slot& slot = slots_[hash % kSlots];
    if (slot.number != View::kNoMaps && std::bit_cast<Bits>(slot.coordinates) == std::bit_cast<Bits>(coordinates))
      return slot.number;
    slot = {coordinates, next};
    return next;
  }
  [[nodiscard]] static constexpr size_t bytes() { return kSlots * sizeof(Slot); }

 private:
  static constexpr size_t kSlots = 4096;
  using Bits = std::array<uint32_t, 6>;
  struct Slot {
    Coordinates coordinates{};
    uint32_t number = View::kNoMaps;
  };
  std::vector<Slot> slots_ = std::vector<Slot>(kSlots);
};

class MicromapBuilder {
 public:
  explicit MicromapBuilder(const OpacityInput& input) : input_(input), classes_of_mesh_(input.geometries.size()) {
    maps_.first.assign(input.geometries.size(), View::kNoMaps);
  }

  void add(uint32_t mesh) {
    const GeometryView& geometry = input_.geometries[mesh];
    classes_of_mesh_[mesh] = &classes_of(input_.materials[geometry.material]);
    maps_.first[mesh] = static_cast<uint32_t>(maps_.entries.size());
    SharedMaps& shared = shared_maps_[geometry.material];
    for (uint32_t triangle = 0; triangle < geometry.indices.size() / 3; ++triangle) {
      const auto next = static_cast<uint32_t>(jobs_.size());
      const uint32_t number = shared.find(coordinates_of(mesh, triangle), next);
      if (number == next) jobs_.push_back({mesh, triangle});
      maps_.entries.push_back(number);
    }
  }

  OpacityMicromaps build() && {
    choose_levels();
    tbb::parallel_for(size_t{0}, jobs_.size(), [&](size_t i) { make(jobs_[i]); });
    for (uint32_t& entry : maps_.entries) entry = View::entry_of(jobs_[entry].level, jobs_[entry].first_word);
    return std::move(maps_);
  }

 private:
  const AlphaClasses& classes_of(const ShadingMaterial& material) {
    const auto texture = static_cast<size_t>(material.base_color.texture);
    const std::pair key(texture, test_of(material));
    const auto found = classes_.find(key);
    return found != classes_.end() ? found->second
                                   : classes_.try_emplace(key, input_.textures[texture], key.second).first->second;
  }

  [[nodiscard]] Coordinates coordinates_of(uint32_t mesh, uint32_t triangle) const {
    const GeometryView& geometry = input_.geometries[mesh];
    const uint8_t set = input_.materials[geometry.material].base_color.texcoord;
    Coordinates coordinates;
    for (size_t k = 0; k < 3; ++k)
      std::copy_n(geometry.record(geometry.indices[size_t{triangle} * 3 + k]) + geometry.texcoord_offset[set], 2,
                  coordinates.begin() + 2 * k);
    return coordinates;
  }
  [[nodiscard]] TexelTriangle triangle_of(const Job& job) const {
    const ShadingMaterial& material = input_.materials[input_.geometries[job.mesh].material];
    return {coordinates_of(job.mesh, job.triangle), material.base_color, classes_of_mesh_[job.mesh]->size_px()};
  }

  void choose_levels() {
    size_t count = 0;
    double texels = kTexelsOfMicroTriangle;
    do {
      count = 0;
      for (Job& job : jobs_) {
        job.level = triangle_of(job).level(texels, View::kMaxLevel);
        count += View::count(job.level);
      }
      texels *= 4.0;
    } while (count > budget(maps_.entries.size()));
    size_t words = 0;
    for (Job& job : jobs_) {
      job.first_word = static_cast<uint32_t>(words);
      if (job.level > 0) words += (View::count(job.level) + View::kStatesPerWord - 1) / View::kStatesPerWord;
    }
    maps_.words.resize(words);
  }

  // Writes the states of a map. One with a single state gets level 0, whose word is that state.
  void make(Job& job) {
    const TexelTriangle triangle = triangle_of(job);
    const AlphaClasses& classes = *classes_of_mesh_[job.mesh];
    const uint32_t rows = 1U << static_cast<uint32_t>(job.level);
    uint32_t micro = 0;
    std::array<bool, 3> seen{};
    for (uint32_t row = 0; row < rows; ++row)
      for (uint32_t i = 0; i < 2 * (rows - row) - 1; ++i, ++micro) {
        const Opacity found = triangle.opacity(classes, job.level, {i / 2, row, i % 2 != 0});
        seen[static_cast<size_t>(found)] = true;
        if (job.level > 0)
          maps_.words[job.first_word + micro / View::kStatesPerWord] |= static_cast<uint32_t>(found)
                                                                        << (micro % View::kStatesPerWord * 2);
      }
    if (std::ranges::count(seen, true) > 1) return;
    job.level = 0;
    job.first_word = static_cast<uint32_t>(std::ranges::find(seen, true) - seen.begin());
  }

  const OpacityInput& input_;
  std::map<std::pair<size_t, AlphaTest>, AlphaClasses> classes_; // by texture
  std::vector<const AlphaClasses*> classes_of_mesh_;
  std::map<uint32_t, SharedMaps> shared_maps_; // by material
  std::vector<Job> jobs_;
  OpacityMicromaps maps_; // while jobs are collected, entries are their numbers
};

} // namespace

uint64_t OpacityMicromaps::max_bytes(const Demand& demand) {
  // Vectors that grow have half of their elements twice. A map of level 1 takes a word for 4
  // states.
  const uint64_t of_triangles = demand.triangles * 3 * (sizeof(uint32_t) + sizeof(Job));
  const uint64_t words = budget(demand.triangles) / 4 * sizeof(uint32_t);
  return of_triangles + words + demand.materials * SharedMaps::bytes() + demand.class_bytes;
}

std::vector<uint8_t> find_covering_meshes(const OpacityInput& input) {
  std::vector<uint8_t> covers(input.geometries.size());
  tbb::parallel_for(size_t{0}, covers.size(), [&](size_t i) { covers[i] = is_opaque(input, input.geometries[i]); });
  return covers;
}

OpacityMicromaps make_opacity_micromaps(const OpacityInput& input, std::span<const uint8_t> covers) {
  MicromapBuilder builder(input);
  bool any = false;
  for (uint32_t mesh = 0; mesh < covers.size(); ++mesh)
    if (covers[mesh] == 0 && has_micromaps(input, input.geometries[mesh])) {
      builder.add(mesh);
      any = true;
    }
  return any ? std::move(builder).build() : OpacityMicromaps();
}

} // namespace kindling
