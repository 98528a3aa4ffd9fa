// Judges hits by the geometry that they name.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/shootout/plugins/examine_hits.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kindling::app {

std::string why_no_hit(const accel::BuildInput& geometry, const accel::Ray& ray, const accel::Hit& hit) {
  if (!hit.is_hit()) return {};
  if (hit.instance >= geometry.instances.size())
    return fmt::format("instance {}; the scene has {}", hit.instance, geometry.instances.size());
  const accel::MeshGroup& group = geometry.groups[geometry.instances[hit.instance].group];
  if (hit.mesh < group.first_mesh || hit.mesh - group.first_mesh >= group.mesh_count)
    return fmt::format("mesh {} of instance {}, which has meshes {} to {}", hit.mesh, hit.instance, group.first_mesh,
                       group.first_mesh + group.mesh_count - 1);
  if (const size_t count = geometry.meshes[hit.mesh].triangle_count(); hit.triangle >= count)
    return fmt::format("triangle {} of mesh {}, which has {}", hit.triangle, hit.mesh, count);
  if (!std::isfinite(hit.t)) return fmt::format("a distance of {}", hit.t);
  if (!(hit.t > ray.t_min && hit.t >= 0.0f && hit.t <= ray.t_max))
    return fmt::format("a distance of {:g}, outside of the ray's ({:g}, {:g}]", hit.t, ray.t_min, ray.t_max);
  constexpr float kSlack = 1e-3f;
  if (!(hit.u >= -kSlack && hit.v >= -kSlack && hit.u + hit.v <= 1.0f + kSlack))
    return fmt::format("barycentric coordinates {:g}, {:g}", hit.u, hit.v);
  return {};
}

bool lies_on_its_triangle(const accel::BuildInput& geometry, const accel::Ray& ray, const accel::Hit& hit) {
  if (!hit.is_hit()) return true;
  const accel::TriangleMesh& mesh = geometry.meshes[hit.mesh];
  const Imath::M44f& matrix = geometry.instances[hit.instance].object_to_world;
  const double weights[3] = {1.0 - static_cast<double>(hit.u) - hit.v, hit.u, hit.v};
  double scale = 0.0;
  Imath::V3d point(0.0);
  for (size_t corner = 0; corner < 3; ++corner) {
    const Imath::V3f& p = mesh.positions[mesh.indices[3 * static_cast<size_t>(hit.triangle) + corner]];
    for (int k = 0; k < 3; ++k) {
      double world = matrix[3][k], size = std::fabs(world);
      for (int row = 0; row < 3; ++row) {
        const double term = static_cast<double>(p[row]) * matrix[row][k];
        world += term;
        size += std::fabs(term);
      }
      point[k] += weights[corner] * world;
      scale = std::max(scale, size);
    }
  }
  double offset = 0.0;
  for (int k = 0; k < 3; ++k) {
    const double way = static_cast<double>(hit.t) * ray.direction[k];
    offset = std::max(offset, std::fabs(ray.origin[k] + way - point[k]));
    scale = std::max({scale, std::fabs(way), std::fabs(static_cast<double>(ray.origin[k]))});
  }
  return offset <= 1e-3 * scale;
}

} // namespace kindling::app
