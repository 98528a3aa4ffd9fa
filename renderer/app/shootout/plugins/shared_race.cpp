// Lays a race out in shared memory, and finds it there again.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/plugins/shared_race.h"

#include <algorithm>
#include <cstring>

namespace kindling::app {

namespace {

// Offsets are from the begin of the memory.
struct RaceHeader {
  uint64_t meshes_at, mesh_count;
  uint64_t groups_at, group_count;
  uint64_t instances_at, instance_count;
  uint64_t sets_at, set_count;
};
struct StoredMesh {
  uint64_t positions_at, position_count;
  uint64_t indices_at, index_count;
};
struct StoredSet {
  char name[32]; // zero-terminated
  uint32_t query, coherent_group;
  uint64_t rays_at, ray_count;
};

// Gives arrays their places one after the other; without memory it only counts.
class Layout {
 public:
  explicit Layout(std::byte* memory) : memory_(memory) {}

  // `padding`: bytes that remain readable after the array.
  template <typename T>
  uint64_t add(std::span<const T> array, size_t padding = 0) {
    const uint64_t at = reserve<T>(array.size(), padding);
    if (memory_ != nullptr && !array.empty()) std::memcpy(memory_ + at, array.data(), array.size_bytes());
    return at;
  }
  template <typename T>
  uint64_t reserve(size_t count, size_t padding = 0) {
    constexpr uint64_t kLine = 64;
    const uint64_t at = (end_ + kLine - 1) / kLine * kLine;
    end_ = at + count * sizeof(T) + padding;
    return at;
  }
  [[nodiscard]] uint64_t end() const { return end_; }

 private:
  std::byte* memory_;
  uint64_t end_ = 0;
};

// Returns the size of the race, and writes it if there is memory.
uint64_t lay_out(const accel::BuildInput& geometry, std::span<const RaySet> sets, std::byte* memory) {
  Layout layout(memory);
  const uint64_t header_at = layout.reserve<RaceHeader>(1);
  RaceHeader header{};
  std::vector<StoredMesh> meshes;
  for (const accel::TriangleMesh& mesh : geometry.meshes)
    meshes.push_back(
        {layout.add(mesh.positions, 16), mesh.positions.size(), layout.add(mesh.indices), mesh.indices.size()});
  header.meshes_at = layout.add(std::span<const StoredMesh>(meshes));
  header.mesh_count = meshes.size();
  header.groups_at = layout.add(geometry.groups);
  header.group_count = geometry.groups.size();
  header.instance_count = geometry.instances.size();
  header.instances_at = layout.reserve<accel::Instance>(header.instance_count);
  if (memory != nullptr)
    for (size_t i = 0; i < header.instance_count; ++i)
      std::memcpy(memory + header.instances_at + i * sizeof(accel::Instance), &geometry.instances[i],
                  sizeof(accel::Instance));
  std::vector<StoredSet> stored_sets;
  for (const RaySet& set : sets) {
    StoredSet& stored = stored_sets.emplace_back();
    std::memcpy(stored.name, set.name.data(), std::min(set.name.size(), sizeof stored.name - 1));
    stored.query = static_cast<uint32_t>(set.query);
    stored.coherent_group = set.coherent_group;
    stored.rays_at = layout.add(std::span<const accel::Ray>(set.rays));
    stored.ray_count = set.rays.size();
  }
  header.sets_at = layout.add(std::span<const StoredSet>(stored_sets));
  header.set_count = stored_sets.size();
  if (memory != nullptr) std::memcpy(memory + header_at, &header, sizeof header);
  return layout.end();
}

} // namespace

Result<SharedMemory> share_race(const accel::BuildInput& geometry, std::span<const RaySet> sets) {
  Result<SharedMemory> memory = SharedMemory::create(lay_out(geometry, sets, nullptr));
  if (memory.ok()) lay_out(geometry, sets, memory.value().data());
  return memory;
}

Result<SharedRace> SharedRace::read(SharedMemory& memory) {
  const Error damaged{ErrorKind::render_failed, "the shared memory holds no race"};
  const auto header = memory.array<RaceHeader>(0, 1);
  if (!header) return damaged;
  const RaceHeader& h = header->front();
  const auto meshes = memory.array<StoredMesh>(h.meshes_at, h.mesh_count);
  const auto groups = memory.array<accel::MeshGroup>(h.groups_at, h.group_count);
  const auto instances = memory.array<accel::Instance>(h.instances_at, h.instance_count);
  const auto sets = memory.array<StoredSet>(h.sets_at, h.set_count);
  if (!meshes || !groups || !instances || !sets) return damaged;
  SharedRace race;
  for (const StoredMesh& stored : *meshes) {
    const auto positions = memory.array<Imath::V3f>(stored.positions_at, stored.position_count);
    const auto indices = memory.array<uint32_t>(stored.indices_at, stored.index_count);
    if (!positions || !indices) return damaged;
    race.meshes_.push_back({.positions = *positions, .indices = *indices});
  }
  race.groups_ = *groups;
  race.instances_ = std::span<const accel::Instance>(*instances);
  for (const StoredSet& stored : *sets) {
    const auto rays = memory.array<accel::Ray>(stored.rays_at, stored.ray_count);
    if (!rays) return damaged;
    race.sets_.push_back({std::string(stored.name, strnlen(stored.name, sizeof stored.name)),
                          static_cast<RayQuery>(stored.query), stored.coherent_group,
                          std::vector<accel::Ray>(rays->begin(), rays->end())});
  }
  return race;
}

size_t answer_bytes(std::span<const RaySet> sets) {
  size_t bytes = 0;
  for (const RaySet& set : sets) bytes = std::max(bytes, set.rays.size() * sizeof(accel::Hit));
  return bytes;
}

} // namespace kindling::app
