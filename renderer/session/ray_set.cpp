// Hashes the geometry that rays are traced through.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/ray_set.h"

#include <bit>

namespace kindling {
namespace {

// FNV-1a by words of 32 bits, with a finalizer: the same on every machine.
class Hasher {
 public:
  void add(uint32_t word) { state_ = (state_ ^ word) * 0x100000001b3ULL; }
  void add(float value) { add(std::bit_cast<uint32_t>(value)); }
  [[nodiscard]] uint64_t result() const {
    uint64_t x = state_;
    x = (x ^ (x >> 33)) * 0xff51afd7ed558ccdULL;
    x = (x ^ (x >> 33)) * 0xc4ceb9fe1a85ec53ULL;
    return x ^ (x >> 33);
  }

 private:
  uint64_t state_ = 0xcbf29ce484222325ULL;
};

} // namespace

uint64_t hash_geometry(const accel::BuildInput& input) {
  Hasher hasher;
  for (const accel::TriangleMesh& mesh : input.meshes) {
    hasher.add(static_cast<uint32_t>(mesh.positions.size()));
    hasher.add(static_cast<uint32_t>(mesh.indices.size()));
    hasher.add(mesh.opaque ? 1U : 0U);
    for (const Imath::V3f& p : mesh.positions)
      for (const float component : {p.x, p.y, p.z}) hasher.add(component);
    for (const uint32_t index : mesh.indices) hasher.add(index);
  }
  for (const accel::MeshGroup& group : input.groups) {
    hasher.add(group.first_mesh);
    hasher.add(group.mesh_count);
  }
  for (size_t number = 0; number < input.instances.size(); ++number) {
    const accel::Instance& instance = input.instances[number];
    hasher.add(instance.group);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) hasher.add(instance.object_to_world[i][j]);
  }
  return hasher.result();
}

} // namespace kindling
