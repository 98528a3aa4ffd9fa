// Random scenes and rays for fuzzing, and the comparison of all queries with the oracle.
// SPDX-License-Identifier: Apache-2.0
#include "tests/accel/fuzz_scenes.h"

#include "accel/rounding.h"
#include "tests/accel/compact_copy.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <sstream>

namespace kindling::accel::testing {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kPi = 3.14159265f;

bool is_finite(const V3f& p) { return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z); }

bool chance(Rng& rng, float probability) { return uniform(rng) < probability; }

int between(Rng& rng, int low, int high) {
  return low + static_cast<int>(rng() % static_cast<uint32_t>(high - low + 1));
}

float power_of_ten(Rng& rng, float low, float high) { return std::pow(10.0f, uniform(rng, low, high)); }

// Returns a random direction with a length that is a random power of ten.
V3f any_size(Rng& rng, float low, float high) {
  const V3f direction = uniform_direction(rng);
  return direction * power_of_ten(rng, low, high);
}

bool accept_by_hash(const void*, const Ray& ray, const Hit& candidate) {
  uint32_t h = ray.key * 2654435761U ^ candidate.triangle * 40503U ^ candidate.mesh * 97U ^ candidate.instance * 31U;
  h ^= h >> 15;
  return (h & 3) != 0;
}

void append(Mesh& mesh, const Mesh& more) {
  const auto base = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), more.positions.begin(), more.positions.end());
  for (const uint32_t i : more.indices) mesh.indices.push_back(base + i);
}

Mesh random_mesh(Rng& rng, int largest) {
  const int count = std::max(1, static_cast<int>(std::pow(static_cast<float>(largest), uniform(rng))));
  const int side = std::max(2, static_cast<int>(std::sqrt(static_cast<float>(count) / 2.0f)));
  switch (rng() % 15) {
  case 0: return triangle_soup(rng, count, 1.0f, power_of_ten(rng, -2.0f, 0.3f));
  case 1: return sphere(side, 2 * side, 1.0f, V3f(0));
  case 2: return gridded_box(std::max(1, side / 3), V3f(-1), V3f(1));
  case 3: return terrain(side, 2.0f, 0.2f);
  case 4: return terrain(side, 2.0f, 0.0f);
  case 5: return slivers(rng, count);
  case 6: return coplanar_pile(rng, count);
  case 7: return duplicates(count);
  case 8: return degenerate(rng, count);
  case 9: return fan(count + 2, chance(rng, 0.5f));
  case 10: return needles(rng, count);
  case 11: return nested_shells(std::max(1, count / 100));
  case 12: return shared_planes(rng, count);
  case 13: return Mesh();
  default: {
    Mesh mixed = triangle_soup(rng, count / 2 + 1, 1.0f, 0.3f);
    append(mixed, degenerate(rng, count / 4 + 1));
    append(mixed, shared_planes(rng, count / 4 + 1));
    return mixed;
  }
  }
}

M44f random_transform(Rng& rng) {
  M44f m, r;
  switch (rng() % 6) {
  case 0: return m; // the identity
  case 1: m.setTranslation(any_size(rng, -3.0f, 3.0f)); return m;
  case 2: m.setScale(power_of_ten(rng, -3.0f, 3.0f)); return m;
  case 3: // singular
    m.setScale(V3f(1, 0, 1));
    return m;
  default: {
    const float side = chance(rng, 0.5f) ? -1.0f : 1.0f;
    m.setScale(
        V3f{power_of_ten(rng, -1.0f, 1.0f), side * power_of_ten(rng, -1.0f, 1.0f), power_of_ten(rng, -1.0f, 1.0f)});
    M44f shear;
    shear[1][0] = uniform(rng, -1.0f, 1.0f);
    const V3f axis = uniform_direction(rng);
    r.setAxisAngle(axis, uniform(rng, 0.0f, 6.0f));
    M44f t;
    const V3f towards = uniform_direction(rng);
    t.setTranslation(towards * uniform(rng, 0.0f, 3.0f));
    return m * shear * r * t;
  }
  }
}

// Picks a triangle in world space; returns false if it has a vertex that is not finite.
bool pick_triangle(Rng& rng, const TestScene& scene, V3f (&p)[3]) {
  if (scene.instances().empty()) return false;
  const BuildInput input = scene.input();
  const Instance& instance = input.instances[rng() % input.instances.size()];
  const MeshGroup& group = input.groups[instance.group];
  if (group.mesh_count == 0) return false;
  const TriangleMesh& mesh = input.meshes[group.first_mesh + rng() % group.mesh_count];
  if (mesh.triangle_count() == 0) return false;
  const size_t triangle = rng() % mesh.triangle_count();
  for (size_t k = 0; k < 3; ++k) {
    p[k] = mesh.positions[mesh.indices[3 * triangle + k]] * instance.object_to_world;
    if (!is_finite(p[k])) return false;
  }
  return true;
}

bool same(const Hit& a, const Hit& b) { return std::memcmp(&a, &b, sizeof(Hit)) == 0; }

void print(std::ostringstream& out, const char* name, const Hit& hit) {
  out << "; " << name;
  if (!hit.is_hit()) {
    out << " none";
    return;
  }
  out << " t " << hit.t << " u " << hit.u << " v " << hit.v << " ids " << hit.instance << ' ' << hit.mesh << ' '
      << hit.triangle;
}

} // namespace

Mesh fan(int valence, bool flat) {
  Mesh mesh;
  const uint32_t center = mesh.add({0.1f, 0.2f, 0.3f});
  for (int i = 0; i < valence; ++i) {
    const float phi = 2.0f * kPi * static_cast<float>(i) / static_cast<float>(valence);
    mesh.add({0.1f + std::cos(phi), 0.2f + std::sin(phi), 0.3f + (flat ? 0.0f : 0.3f * std::sin(5.0f * phi))});
  }
  const auto n = static_cast<uint32_t>(valence);
  for (uint32_t i = 0; i < n; ++i) mesh.indices.insert(mesh.indices.end(), {center, 1 + i, 1 + (i + 1) % n});
  return mesh;
}

Mesh needles(Rng& rng, int count) {
  Mesh mesh;
  for (int i = 0; i < count; ++i) {
    const V3f start = V3f(-1.0f) + uniform_direction(rng) * 0.3f;
    mesh.add_triangle(start, start + V3f(2.0f), start + any_size(rng, -5.0f, -1.0f));
  }
  return mesh;
}

Mesh nested_shells(int count) {
  Mesh mesh;
  for (int i = 0; i < count; ++i)
    append(mesh,
           sphere(5, 10, i % 2 == 0 ? 1.0f + 1e-6f * static_cast<float>(i) : 1.0f / static_cast<float>(i + 1), V3f(0)));
  return mesh;
}

Mesh shared_planes(Rng& rng, int count) {
  Mesh mesh;
  const auto coordinate = [&] { return 0.25f * static_cast<float>(between(rng, -4, 4)); };
  for (int i = 0; i < count; ++i) {
    const int axis = between(rng, 0, 2);
    V3f a(coordinate(), coordinate(), coordinate()), b = a, c = a;
    b[(axis + 1) % 3] = coordinate();
    c[(axis + 2) % 3] = coordinate();
    mesh.add_triangle(a, b, c);
  }
  return mesh;
}

Mesh moved_by(Mesh mesh, const V3f& offset) {
  for (V3f& p : mesh.positions) p += offset;
  return mesh;
}

std::deque<NamedScene> hostile_scenes() {
  Rng rng(307);
  std::deque<NamedScene> scenes;
  const auto add = [&](const std::string& name, Mesh mesh) { scenes.push_back({name, TestScene(std::move(mesh))}); };
  add("coplanar along an axis", coplanar_pile(rng, 200));
  Mesh tilted = coplanar_pile(rng, 200);
  for (V3f& p : tilted.positions) p.y = 0.5f * p.x - 0.25f * p.z;
  add("coplanar and tilted", tilted);
  add("flat grid", terrain(10, 2.0f, 0.0f));
  add("degenerate", degenerate(rng, 120));
  add("duplicates", duplicates(150));
  add("slivers", slivers(rng, 150));
  for (const float scale : {1e-20f, 1e-10f, 1e-6f, 1e6f, 1e12f, 1e15f}) {
    std::ostringstream name;
    name << "scale " << scale;
    add(name.str(), scaled(triangle_soup(rng, 150, 1.0f, 0.4f), scale));
  }
  Mesh scales = triangle_soup(rng, 40, 1.0f, 0.4f);
  append(scales, scaled(triangle_soup(rng, 40, 1.0f, 0.4f), 1e-6f));
  append(scales, scaled(triangle_soup(rng, 40, 1.0f, 0.4f), 1e6f));
  add("scales from 1e-6 to 1e6", scales);
  Mesh one;
  one.add_triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
  add("one triangle", one);
  add("none", Mesh());
  add("flat fan", fan(150, true));
  add("bent fan", fan(150, false));
  add("needles", needles(rng, 150));
  add("nested shells", nested_shells(3));
  add("shared planes", shared_planes(rng, 200));
  add("gridded box", gridded_box(4, V3f(-1), V3f(1)));
  add("sphere off the origin", moved_by(sphere(8, 16, 1.0f, V3f(0)), V3f(300.0f, -200.0f, 50.0f)));
  Mesh broken = sphere(8, 12, 1.0f, V3f(0));
  for (size_t i = 0; i < broken.positions.size(); i += 7)
    broken.positions[i][static_cast<int>(i % 3)] = i % 2 == 0 ? kNan : -kInfinity;
  add("vertices that are not finite", broken);
  return scenes;
}

TestScene random_scene(Rng& rng, int largest) {
  TestScene scene;
  const float scale = chance(rng, 0.1f) ? power_of_ten(rng, -6.0f, 12.0f) : power_of_ten(rng, -3.0f, 3.0f);
  const bool instances = chance(rng, 0.5f), cut_outs = chance(rng, 0.33f);
  const int groups = instances ? between(rng, 1, 3) : 1;
  for (int g = 0; g < groups; ++g) {
    std::vector<Mesh> meshes;
    for (int m = between(rng, 1, 4); m > 0; --m) {
      Mesh mesh = random_mesh(rng, largest);
      if (chance(rng, 0.3f)) mesh = scaled(mesh, power_of_ten(rng, -2.0f, 2.0f));
      if (chance(rng, 0.3f)) mesh = moved_by(mesh, any_size(rng, -1.0f, 2.0f));
      mesh = scaled(mesh, scale);
      mesh.opaque = !(cut_outs && chance(rng, 0.6f));
      meshes.push_back(std::move(mesh));
    }
    const uint32_t group = scene.add_group(std::move(meshes));
    for (int i = instances ? between(rng, 0, 5) : 1; i > 0; --i) {
      M44f m = instances ? random_transform(rng) : M44f();
      for (int k = 0; k < 3; ++k) m[3][k] *= scale;
      scene.add_instance(group, m);
    }
  }
  if (cut_outs) scene.set_filter({accept_by_hash, nullptr});
  return scene;
}

std::vector<Ray> aimed_rays(Rng& rng, const TestScene& scene, int count) {
  const Box3f bounds = scene.bounds();
  const Box3f box = bounds.isEmpty() ? Box3f(V3f(-1), V3f(1)) : bounds;
  const float extent = std::max((box.max - box.min).length(), 1e-30f);
  std::vector<Ray> rays;
  for (int i = 0; i < count; ++i) {
    V3f p[3];
    if (!pick_triangle(rng, scene, p))
      for (V3f& q : p) q = uniform_in(rng, box);
    const V3f along = p[0] + (p[1] - p[0]) * uniform(rng) * 0.5f;
    const V3f inside = along + (p[2] - p[0]) * uniform(rng) * 0.5f;
    const V3f edge = p[0] + (p[1] - p[0]) * uniform(rng);
    const V3f target = rng() % 3 == 0 ? p[0] : rng() % 2 == 0 ? edge : inside;
    const float size = (p[1] - p[0]).length() + (p[2] - p[0]).length();
    Ray ray;
    ray.t_max = kInfinity;
    ray.key = static_cast<uint32_t>(rng());
    const V3f beside = uniform_direction(rng) * extent;
    ray.origin = rng() % 4 == 0 ? target + beside * uniform(rng, 0.0f, 2.0f) : uniform_in(rng, box);
    ray.direction = target - ray.origin;
    switch (rng() % 8) {
    case 0: // toward any point
      ray.direction = uniform_in(rng, box) - ray.origin;
      break;
    case 1: // along an axis, with zeros of both signs
    case 2: {
      const int axis = between(rng, 0, 2);
      ray.origin = rng() % 2 == 0 ? target : V3f(0.5f) * (box.min + box.max);
      ray.origin[(axis + 1) % 3] = target[(axis + 1) % 3];
      ray.origin[axis] = rng() % 2 == 0 ? ray.origin[axis] : uniform(rng) < 0.5f ? box.min[axis] : box.max[axis];
      ray.direction = V3f(rng() % 2 == 0 ? 0.0f : -0.0f);
      ray.direction[axis] = rng() % 2 == 0 ? extent : -extent;
      if (rng() % 2 == 0) ray.origin[axis] -= ray.direction[axis];
      break;
    }
    case 3: // in the plane of the triangle, or close to it
      ray.direction = (p[1] - p[0]) * uniform(rng, -1.0f, 1.0f);
      ray.direction += (p[2] - p[0]) * uniform(rng, -1.0f, 1.0f);
      ray.origin = inside - ray.direction * uniform(rng, 0.0f, 3.0f);
      if (rng() % 2 == 0) ray.origin += any_size(rng, -8.0f, -3.0f) * size;
      break;
    case 4: // along an edge, from a vertex
      ray.origin = p[0];
      ray.direction = p[1] - p[0];
      break;
    case 5: // leaves a surface
      ray.origin = target;
      if (rng() % 2 == 0) ray.origin += any_size(rng, -8.0f, -3.0f) * size;
      ray.direction = uniform_direction(rng) * extent;
      break;
    default: break;
    }
    if (rng() % 3 == 0) ray.direction *= power_of_ten(rng, -3.0f, 3.0f) / extent;
    if (rng() % 3 == 0) ray.direction.normalize();
    switch (rng() % 64) {
    case 0: ray.t_min = kNan; break;
    case 1: ray.t_max = kNan; break;
    case 2: ray.t_max = -1.0f; break;
    case 3: ray.t_min = -1.0f; break;
    case 4: ray.direction = V3f(0); break;
    case 5: ray.origin[between(rng, 0, 2)] = rng() % 2 == 0 ? kNan : kInfinity; break;
    default: break;
    }
    rays.push_back(ray);
  }
  return rays;
}

std::vector<Ray> coherent_rays(Rng& rng, const TestScene& scene, int groups) {
  const Box3f bounds = scene.bounds();
  const Box3f box = bounds.isEmpty() ? Box3f(V3f(-1), V3f(1)) : bounds;
  const float extent = std::max((box.max - box.min).length(), 1e-30f);
  std::vector<Ray> rays;
  for (int group = 0; group < groups; ++group) {
    const float radius = extent * power_of_ten(rng, -3.0f, 0.0f);
    const V3f towards = uniform_direction(rng), aim = uniform_in(rng, box), origin = aim - towards * extent;
    for (int i = 0; i < 64; ++i) {
      V3f target = aim + uniform_in(rng, Box3f(V3f(-radius), V3f(radius))), p[3];
      if (rng() % 2 == 0 && pick_triangle(rng, scene, p))
        target = rng() % 2 == 0 ? p[0] : p[0] + (p[1] - p[0]) * uniform(rng);
      Ray ray;
      ray.t_max = kInfinity;
      ray.key = static_cast<uint32_t>(rng());
      ray.direction = group % 2 == 0 ? target - origin : towards;
      ray.origin = group % 2 == 0 ? origin : target - towards * extent;
      if (rng() % 300 == 0) ray.t_max = -1.0f;
      rays.push_back(ray);
    }
  }
  return rays;
}

void cut_at_hits(Rng& rng, const Accelerator& oracle, std::span<Ray> rays) {
  for (Ray& ray : rays) {
    if (rng() % 3 != 0) continue;
    const Hit hit = oracle.intersect(ray);
    if (!hit.is_hit()) continue;
    switch (rng() % 6) {
    case 0: ray.t_max = hit.t; break;
    case 1: ray.t_max = std::nextafter(hit.t, 0.0f); break;
    case 2: ray.t_min = hit.t; break;
    case 3: ray.t_min = std::nextafter(hit.t, 0.0f); break;
    case 4: ray.t_max = hit.t * uniform(rng, 0.5f, 2.0f); break;
    default: ray.t_min = hit.t * uniform(rng, 0.5f, 2.0f); break;
    }
  }
}

void Comparison::fail(const Ray& ray, const std::string& what, const Hit& expected, const Hit& found) {
  if (failures++ != 0) return;
  std::ostringstream out;
  out.precision(9);
  out << what << ": ray o " << ray.origin << " d " << ray.direction << " in (" << ray.t_min << ", " << ray.t_max
      << "] key " << ray.key;
  print(out, "expected", expected);
  print(out, "found", found);
  first_failure = out.str();
}

void compare(const Accelerator& oracle, const Accelerator& tested, std::span<const Ray> rays, size_t batch,
             Comparison& comparison) {
  const CompactCopy compact(tested);
  std::vector<Hit> hits, coherent;
  std::vector<uint8_t> blocked, blocked_coherent;
  for (size_t first = 0; first < rays.size(); first += batch) {
    const std::span<const Ray> part = rays.subspan(first, std::min(batch, rays.size() - first));
    Hit stale;
    stale.instance = stale.triangle = 5;
    hits.assign(part.size(), stale);
    coherent.assign(part.size(), stale);
    blocked.assign(part.size(), 7);
    blocked_coherent.assign(part.size(), 7);
    tested.intersect(part, hits);
    tested.intersect_coherent(part, coherent);
    tested.occluded(part, blocked);
    tested.occluded_coherent(part, blocked_coherent);
    for (size_t i = 0; i < part.size(); ++i) {
      const Ray& ray = part[i];
      const Hit expected = oracle.intersect(ray), found = tested.intersect(ray);
      ++comparison.rays;
      comparison.hits += expected.is_hit() ? 1 : 0;
      const uint8_t is_blocked = expected.is_hit() ? 1 : 0;
      if (!same(found, expected)) comparison.fail(ray, "single", expected, found);
      const Hit by_compact = compact.intersect(ray);
      if (!same(by_compact, expected)) comparison.fail(ray, "compact", expected, by_compact);
      if (compact.occluded(ray) != expected.is_hit()) comparison.fail(ray, "compact any hit", expected, found);
      if (!same(hits[i], expected)) comparison.fail(ray, "batch", expected, hits[i]);
      if (!same(coherent[i], expected)) comparison.fail(ray, "coherent", expected, coherent[i]);
      if (oracle.occluded(ray) != expected.is_hit()) comparison.fail(ray, "any hit of the oracle", expected, found);
      if (tested.occluded(ray) != expected.is_hit()) comparison.fail(ray, "any hit", expected, found);
      if (blocked[i] != is_blocked) comparison.fail(ray, "any-hit batch", expected, found);
      if (blocked_coherent[i] != is_blocked) comparison.fail(ray, "coherent any hit", expected, found);
    }
  }
}

} // namespace kindling::accel::testing
