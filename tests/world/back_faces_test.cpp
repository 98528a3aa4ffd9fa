// Backs of single-sided faces among thousands of random quads, against an intersection in double.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/motion_scenes.h"

#include <ImathMatrix.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using Imath::M44d;
using Imath::V3d;

constexpr int kMeshes = 30, kQuadsOfEach = 20;
constexpr int kDoubleSided = 0, kSingleSided = 1, kLamp = 2, kMaterials = 3;
constexpr Shutter kShutter{0.0, 1.0};
const V3f kEye(6.0f, 5.0f, 4.0f);

float uniform(std::mt19937& rng, float low, float high) {
  return low + (high - low) * static_cast<float>(rng() >> 8) * 0x1p-24f;
}
V3f uniform_in(std::mt19937& rng, float half_side) {
  V3f v;
  for (int axis = 0; axis < 3; ++axis) v[axis] = uniform(rng, -half_side, half_side);
  return v;
}
V3f uniform_direction(std::mt19937& rng) {
  for (;;) {
    const V3f v = uniform_in(rng, 1.0f);
    if (v.length2() > 0.01f && v.length2() <= 1.0f) return v.normalized();
  }
}

Primitive random_quads(std::mt19937& rng, int material) {
  Primitive all;
  all.material = material;
  for (int i = 0; i < kQuadsOfEach; ++i) {
    const V3f along = uniform_direction(rng), across = uniform_direction(rng).cross(along).normalized();
    const float width = uniform(rng, 0.3f, 1.0f), height = uniform(rng, 0.3f, 1.0f);
    const V3f u = along * width, v = across * height;
    const Primitive one = quad(uniform_in(rng, 3.0f), u, v, material);
    const auto first = static_cast<uint32_t>(all.positions.size());
    all.positions.insert(all.positions.end(), one.positions.begin(), one.positions.end());
    for (const uint32_t index : one.indices) all.indices.push_back(first + index);
  }
  return all;
}

// Meshes of quads of two materials, each placed up to five times: as it is, turned, mirrored and
// scaled, and both of it moving. 3,000 quads and more.
Scene random_scene() {
  std::mt19937 rng(71);
  Scene scene;
  scene.source = "test";
  scene.materials = {diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.5f)), emissive_material(Rgb(1.0f))};
  scene.materials[kSingleSided].double_sided = scene.materials[kLamp].double_sided = false;
  scene.scenes.emplace_back();
  for (int mesh = 0; mesh < kMeshes; ++mesh) {
    scene.meshes.emplace_back();
    scene.meshes.back().primitives = {random_quads(rng, mesh % kMaterials), random_quads(rng, kSingleSided)};
    for (int placement = 0; placement <= mesh % 5; ++placement) {
      const auto number = static_cast<int>(scene.nodes.size());
      Node node;
      node.mesh = mesh;
      if (placement > 0) {
        const V3f axis = uniform_direction(rng) * std::sin(1.0f);
        node.local.rotation = Quatf(std::cos(1.0f), axis);
        node.local.translation = uniform_in(rng, 1.0f);
        for (int i = 0; i < 3; ++i) node.local.scale[i] = uniform(rng, 0.5f, 1.5f);
      }
      if (placement == 2 || placement == 4) node.local.scale[mesh % 3] *= -1.0f;
      if (placement == 3) node.local.scale = -node.local.scale;
      scene.nodes.push_back(node);
      scene.scenes[0].nodes.push_back(number);
      if (placement < 3) continue;
      animate_turn(scene, number, V3f(0, 1, 0), 50.0f);
      animate(scene, number, AnimatedProperty::translation, {0, 1}, {0, 0, 0, 0.7f, -1, 0.5f});
    }
  }
  return scene;
}

std::unique_ptr<const World> world_of(accel::Kind kind, bool hide_backs, bool cut) {
  Scene scene = random_scene();
  Result<PosedScene> posed = pose_scene(scene, {.shutter = kShutter});
  EXPECT_TRUE(posed.ok());
  WorldOptions options;
  options.accelerator = kind;
  options.studio = Studio::off;
  options.hide_backs = hide_backs;
  if (cut) options.view_point = ViewPoint{kEye};
  Result<std::unique_ptr<const World>> world =
      build_world(std::move(scene), std::move(posed).value(), options, nullptr, nullptr);
  EXPECT_TRUE(world.ok());
  return std::move(world).value();
}

struct DoubleQuad {
  V3d corner, u, v;
  V3d normal;         // u x v
  double front = 1.0; // +1: the front is where the normal points to; -1: mirrored
  int material = kNone;
};

// All quads at a time of the shutter. Of a mirrored object the front is the mirror image of its
// front, so that the cross product of its edges points to its back.
std::vector<DoubleQuad> quads_at(const Scene& scene, const PosedScene& posed, double time) {
  std::vector<DoubleQuad> quads;
  for (const PosedMesh& mesh : posed.meshes) {
    M44d m(mesh.mesh_to_world);
    if (const size_t intervals = mesh.later_transforms.size(); intervals > 0) {
      const double at = time * static_cast<double>(intervals);
      const size_t first = std::min(static_cast<size_t>(at), intervals - 1);
      const double share = at - static_cast<double>(first);
      const M44d a(first == 0 ? mesh.mesh_to_world : mesh.later_transforms[first - 1]), b(mesh.later_transforms[first]);
      for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
          m[row][column] = (1.0 - share) * a[row][column] + share * b[row][column];
    }
    for (const Primitive& primitive : scene.meshes[static_cast<size_t>(mesh.mesh)].primitives)
      for (size_t i = 0; i < primitive.positions.size(); i += 4) {
        const V3d corner = V3d(primitive.positions[i]) * m;
        DoubleQuad q{
            corner,   V3d(primitive.positions[i + 1]) * m - corner, V3d(primitive.positions[i + 3]) * m - corner,
            V3d(0.0), m.determinant() < 0.0 ? -1.0 : 1.0,           primitive.material};
        q.normal = q.u.cross(q.v);
        quads.push_back(q);
      }
  }
  return quads;
}

struct Crossing {
  double t = 0.0;
  double tolerance = 0.0; // of t
  const DoubleQuad* quad = nullptr;
  bool at_edge = false; // or just beyond it
  bool grazing = false;

  [[nodiscard]] bool sure() const { return !at_edge && !grazing; }
};

// Coordinates of a few meters are rounded to 5e-7 m, a few times.
constexpr double kRounding_m = 1e-5, kEdge = 1e-4, kGrazing = 2e-3;

// Returns what the line crosses, near to far. `direction` is unit.
std::vector<Crossing> crossings(const std::vector<DoubleQuad>& quads, const V3d& origin, const V3d& direction) {
  std::vector<Crossing> found;
  for (const DoubleQuad& q : quads) {
    const double along = direction.dot(q.normal), length2 = q.normal.length2();
    const double cosine = std::abs(along) / std::sqrt(length2);
    if (cosine < 1e-9) continue;
    const double t = (q.corner - origin).dot(q.normal) / along;
    const V3d p = origin + direction * t - q.corner;
    const double a = p.cross(q.v).dot(q.normal) / length2, b = q.u.cross(p).dot(q.normal) / length2;
    const double margin = std::min({a, b, 1.0 - a, 1.0 - b});
    const bool grazing = cosine < kGrazing;
    if (margin < (grazing ? -0.1 : -kEdge)) continue;
    found.push_back({t, kRounding_m / cosine, &q, margin < kEdge, grazing});
  }
  std::sort(found.begin(), found.end(), [](const Crossing& a, const Crossing& b) { return a.t < b.t; });
  return found;
}

bool is_back(const DoubleQuad& q, const V3d& direction) {
  return q.material != kDoubleSided && q.front * q.normal.dot(direction) > 0.0;
}

enum class Rays { camera, every_face, secondary };
enum class Answer { yes, no, unsure };

// Returns yes if `cull` removes the face at `point`: the eye sees its back, and nothing is in
// between.
Answer is_cut(const std::vector<DoubleQuad>& quads, const DoubleQuad& q, const V3d& point) {
  const V3d sight = point - V3d(kEye);
  const double distance = sight.length();
  const V3d direction = sight / distance;
  if (q.material == kLamp || !is_back(q, sight)) return Answer::no;
  if (std::abs(direction.dot(q.normal)) < kGrazing * q.normal.length()) return Answer::unsure;
  for (const Crossing& crossing : crossings(quads, V3d(kEye), direction)) {
    if (crossing.quad == &q || crossing.t < -crossing.tolerance) continue;
    if (crossing.t > distance + crossing.tolerance) break;
    if (is_back(*crossing.quad, sight) && !crossing.grazing) continue;
    const bool between = crossing.t > crossing.tolerance && crossing.t < distance * (1.0 - 2e-4) - crossing.tolerance;
    return between && crossing.sure() ? Answer::no : Answer::unsure;
  }
  return Answer::yes;
}

struct Expected {
  Answer hit = Answer::no;
  double t = 0.0, tolerance = 0.0;
  bool skipped_back = false; // a face that is not seen is before it
};

Expected expected_hit(const std::vector<DoubleQuad>& quads, const accel::Ray& ray, Rays kind, bool hides, bool cut) {
  const V3d origin(ray.origin), direction(ray.direction);
  Expected expected;
  for (const Crossing& crossing : crossings(quads, origin, direction.normalized())) {
    if (crossing.t < -crossing.tolerance) continue;
    if (crossing.t > static_cast<double>(ray.t_max) + crossing.tolerance) break;
    Answer seen = Answer::yes;
    if (hides && kind == Rays::camera) seen = is_back(*crossing.quad, direction) ? Answer::no : Answer::yes;
    if (hides && kind == Rays::secondary && cut) {
      const Answer away = is_cut(quads, *crossing.quad, origin + direction * crossing.t);
      seen = away == Answer::yes ? Answer::no : away == Answer::no ? Answer::yes : Answer::unsure;
    }
    if (crossing.grazing || (crossing.at_edge && seen == Answer::yes)) seen = Answer::unsure;
    if (seen == Answer::no) {
      expected.skipped_back = true;
      continue;
    }
    const bool at_end =
        crossing.t < crossing.tolerance || crossing.t > static_cast<double>(ray.t_max) - crossing.tolerance;
    expected.hit = at_end ? Answer::unsure : seen;
    expected.t = crossing.t;
    expected.tolerance = crossing.tolerance;
    return expected;
  }
  return expected;
}

struct Counts {
  int hits = 0, misses = 0, passed_backs = 0, unsure = 0;
};

Counts compare(const World& world, Rays kind, bool hides, bool cut, int rays) {
  const Scene scene = random_scene();
  const PosedScene posed = pose_scene(scene, {.shutter = kShutter}).value();
  std::mt19937 rng(73);
  Counts counts;
  for (const float time : {0.0f, 0.3f, 0.5f, 0.85f, 1.0f}) {
    const std::vector<DoubleQuad> quads = quads_at(scene, posed, static_cast<double>(time));
    for (int i = 0; i < rays / 5; ++i) {
      accel::Ray ray{.origin = uniform_in(rng, 6.0f), .direction = uniform_direction(rng), .time = time};
      ray.t_max = uniform(rng, 0.2f, 4.0f);
      if (i % 2 == 0) ray.t_max = kInfinity;
      ray.flags = kind == Rays::camera ? kCameraRay : kind == Rays::every_face ? kCameraRay | kEveryFace : 0;
      const Expected expected = expected_hit(quads, ray, kind, hides, cut);
      if (expected.hit == Answer::unsure) {
        ++counts.unsure;
        continue;
      }
      const accel::Hit hit = world.accelerator().intersect(ray);
      const bool blocked = world.accelerator().occluded(ray);
      EXPECT_EQ(blocked, expected.hit == Answer::yes) << "any hit, ray " << i << " at " << time;
      EXPECT_EQ(hit.is_hit(), expected.hit == Answer::yes) << "nearest hit, ray " << i << " at " << time;
      if (hit.is_hit()) {
        EXPECT_NEAR(hit.t, expected.t, expected.tolerance) << "ray " << i << " at " << time;
      }
      if (testing::Test::HasFailure()) return counts;
      ++(hit.is_hit() ? counts.hits : counts.misses);
      counts.passed_backs += expected.skipped_back ? 1 : 0;
    }
  }
  return counts;
}

struct RayCase {
  const char* name;
  Rays kind;
  bool hides, cut;
};
constexpr RayCase kRayCases[] = {{"show", Rays::camera, false, false},
                                 {"cull", Rays::camera, true, false},
                                 {"every face", Rays::every_face, true, true},
                                 {"secondary", Rays::secondary, true, false},
                                 {"cut away", Rays::secondary, true, true}};

TEST(BackFaceHits, AgreeWithDoublePrecision) {
  size_t placed = 0;
  const Scene scene = random_scene();
  for (const Node& node : scene.nodes)
    placed += 2 * static_cast<size_t>(kQuadsOfEach) * static_cast<size_t>(node.mesh != kNone);
  EXPECT_GE(placed, 3000U);
  for (const accel::Kind kind : kAllKinds)
    for (const RayCase& c : kRayCases) {
      SCOPED_TRACE(std::string(accel::kind_name(kind)) + ", " + c.name);
      const auto world = world_of(kind, c.hides, c.cut);
      EXPECT_EQ(world->hides_backs, c.hides);
      EXPECT_TRUE(world->has_motion);
      const int rays = 4000;
      const Counts counts = compare(*world, c.kind, c.hides, c.cut, rays);
      EXPECT_LT(counts.unsure, rays / 20);
      EXPECT_GT(counts.hits, rays / 4);
      EXPECT_GT(counts.misses, rays / 50);
      const bool passes = c.hides && (c.kind == Rays::camera || (c.kind == Rays::secondary && c.cut));
      EXPECT_GT(counts.passed_backs, passes ? rays / 80 : -1);
      if (!passes) {
        EXPECT_EQ(counts.passed_backs, 0);
      }
    }
}

} // namespace
} // namespace kindling::test
