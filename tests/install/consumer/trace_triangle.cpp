// One ray against one triangle through each accelerator of the installed library.
// SPDX-License-Identifier: Apache-2.0
#include "accel/make_accelerator.h"

#include <cmath>
#include <cstdio>
#include <vector>

namespace accel = kindling::accel;

int main() {
  std::vector<Imath::V3f> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  positions.reserve(positions.size() + 2); // 16 readable bytes behind the last one
  const std::vector<uint32_t> indices{0, 1, 2};
  const std::vector<accel::TriangleMesh> meshes{{.positions = positions, .indices = indices}};
  const std::vector<accel::MeshGroup> groups{{.first_mesh = 0, .mesh_count = 1}};
  const std::vector<accel::Instance> instances{{.group = 0, .object_to_world = {}}};
  const accel::BuildInput input{.meshes = meshes, .groups = groups, .instances = instances, .filter = {}};
  accel::Ray ray;
  ray.origin = {0.25f, 0.5f, 2.0f};
  ray.direction = {0.0f, 0.0f, -1.0f};
  ray.t_max = 10.0f;
  for (const accel::Kind kind : {accel::Kind::brute_force, accel::Kind::embree, accel::Kind::kdtree}) {
    const auto accelerator = accel::make_accelerator(kind, input);
    const accel::Hit hit = accelerator->intersect(ray);
    if (!hit.is_hit() || std::abs(hit.t - 2.0f) > 1e-5f || std::abs(hit.u - 0.25f) > 1e-5f ||
        std::abs(hit.v - 0.5f) > 1e-5f) {
      std::printf("%s: t %g u %g v %g\n", std::string(accel::kind_name(kind)).c_str(), hit.t, hit.u, hit.v);
      return 1;
    }
  }
  return 0;
}
