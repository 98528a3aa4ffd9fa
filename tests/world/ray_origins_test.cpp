// Origins of rays that leave hits near edges: on the inner side of all walls, and only then moved.
// SPDX-License-Identifier: Apache-2.0
#include "tests/base/same_bits.h"
#include "tests/integrator/closed_boxes.h"

#include "accel/affine.h"
#include "accel/motion.h"
#include "renderer/base/hash.h"
#include "renderer/world/ray_origins.h"

namespace kindling::test {
namespace {

class Numbers {
 public:
  float operator()() { return static_cast<float>(hash_combine(17U, next_++) >> 8U) * 0x1p-24f; }
  float between(float low, float high) { return low + (high - low) * (*this)(); }

 private:
  uint32_t next_ = 0;
};

// A ray from the inside of a box around `center` to a point that is a few errors off an edge.
accel::Ray ray_to_edge(const V3f& center, const M44f& turn, Numbers& u) {
  V3f from, to;
  for (unsigned i = 0; i < 3; ++i) from[i] = u.between(-0.95f, 0.95f), to[i] = u.between(-1.0f, 1.0f);
  const auto wall = static_cast<unsigned>(u() * 3.0f), beside = (wall + 1) % 3;
  const float error = position_bound(max_abs(center) + 1.0f);
  to[wall] = u() < 0.5f ? -1.0f : 1.0f;
  to[beside] = (u() < 0.5f ? -1.0f : 1.0f) * (1.0f - std::min(error * u() * u() * 4.0f, 0.5f));
  from = transform_point(turn, from);
  to = transform_point(turn, to);
  return {.origin = from, .direction = (to - from).normalized(), .t_max = kInfinity, .flags = kHitPartlyTransparent};
}

// The planes of a convex body's triangles, in double precision; heights are positive inside.
struct Planes {
  std::vector<std::pair<V3d, V3d>> planes; // point and unit normal

  Planes(const Primitive& primitive, const V3f& inside) {
    for (size_t i = 0; i < primitive.indices.size(); i += 3) {
      const V3d p0(primitive.positions[primitive.indices[i]]), p1(primitive.positions[primitive.indices[i + 1]]),
          p2(primitive.positions[primitive.indices[i + 2]]);
      const V3d n = (p1 - p0).cross(p2 - p0).normalized();
      planes.emplace_back(p0, n.dot(V3d(inside) - p0) < 0.0 ? -n : n);
    }
  }
  [[nodiscard]] double height(const V3f& p) const {
    double lowest = 1e300;
    for (const auto& [point, normal] : planes) lowest = std::min(lowest, normal.dot(V3d(p) - point));
    return lowest;
  }
};

TEST(RayOrigins, StayInsideOfBoxes) {
  for (const accel::Kind kind : kAllKinds)
    for (const float distance : {0.0f, 10.0f, 1000.0f, 10000.0f})
      for (const bool turned : {false, true}) {
        const V3f center = center_at(distance);
        const M44f turn = turned ? turned_to(center) : moved_to(center);
        const Primitive walls = box_walls(turn);
        const Planes planes(walls, center);
        // The two triangles of a turned wall lie in one plane up to the rounding of its corners
        // only.
        const double fold =
            turned ? static_cast<double>(std::numeric_limits<float>::epsilon()) * (static_cast<double>(distance) + 1.0)
                   : 0.0;
        const auto world = make_world(make_scene({diffuse_material(Rgb(1.0f))}, {walls}), kind);
        Numbers u;
        int blocked = 0, guarded = 0, plain_outside = 0;
        constexpr int kRays = 20000;
        for (int i = 0; i < kRays; ++i) {
          const accel::Ray ray = ray_to_edge(center, turn, u);
          if (planes.height(ray.origin) <= 0.0) continue;
          const accel::Hit hit = world->accelerator().intersect(ray);
          ASSERT_TRUE(hit.is_hit());
          SurfacePoint surface;
          world->surface_at(ray, hit, surface);
          guarded += surface.guarded ? 1 : 0;
          plain_outside += planes.height(origin_beside(surface, false)) <= -fold ? 1 : 0;
          if (surface.unlit) {
            ++blocked;
            continue;
          }
          const V3f origin = offset_ray_origin(surface, surface.geometric_normal);
          EXPECT_GT(planes.height(origin), -fold) << "ray " << i << " at distance " << distance;
          // Not moved farther than needed.
          EXPECT_LT((origin - surface.position).length(), 1200.0f * surface.position_error);
        }
        EXPECT_GT(guarded, kRays / 2);
        EXPECT_LT(blocked, kRays / 1000);
        // The test is about something: plain offsets leave the box.
        EXPECT_TRUE(turned || plain_outside > 0) << "distance " << distance;
      }
}

// Walls that stand on the inside of large triangles: hits near them are not near an edge of theirs.
TEST(RayOrigins, StayInsideOfWallsThatStandOnOthers) {
  for (const accel::Kind kind : kAllKinds)
    for (const float distance : {0.0f, 1000.0f, 10000.0f}) {
      const V3f center = center_at(distance);
      const auto world = make_world(make_scene({diffuse_material(Rgb(1.0f))}, t_junctions(center)), kind);
      const Planes planes(box_walls(moved_to(center)), center);
      Numbers u;
      for (int i = 0; i < 20000; ++i) {
        const accel::Ray ray = ray_to_edge(center, moved_to(center), u);
        if (planes.height(ray.origin) <= 0.0) continue;
        const accel::Hit hit = world->accelerator().intersect(ray);
        ASSERT_TRUE(hit.is_hit());
        SurfacePoint surface;
        world->surface_at(ray, hit, surface);
        if (surface.unlit) continue;
        EXPECT_GT(planes.height(offset_ray_origin(surface, surface.geometric_normal)), 0.0)
            << "ray " << i << " at distance " << distance;
      }
    }
}

// A thin-walled sheet in the middle of a box, from wall to wall: both origins are inside of the
// box, each on its side of the sheet.
TEST(RayOrigins, LieOnBothSidesOfAThinWall) {
  Material sheet;
  sheet.metallic_factor = sheet.roughness_factor = 0.0f;
  sheet.transmission_factor = 1.0f;
  sheet.double_sided = true;
  for (const accel::Kind kind : kAllKinds)
    for (const float distance : {0.0f, 1000.0f, 10000.0f}) {
      const V3f center = center_at(distance);
      const Primitive walls = box_walls(moved_to(center));
      const Planes planes(walls, center);
      const auto world = make_world(make_scene({diffuse_material(Rgb(1.0f)), sheet},
                                               {walls, quad(center + V3f(0, -1, -1), V3f(0, 2, 0), V3f(0, 0, 2), 1)}),
                                    kind);
      Numbers u;
      const float error = position_bound(max_abs(center) + 1.0f);
      int passed = 0, blocked = 0;
      for (int i = 0; i < 20000; ++i) {
        const V3f from = center + V3f(u.between(0.1f, 0.9f), u.between(-0.9f, 0.9f), u.between(-0.9f, 0.9f));
        const V3f to = center + V3f(0.0f, -1.0f + std::min(error * u() * 4.0f, 0.5f), u.between(-0.9f, 0.9f));
        const accel::Ray ray{
            .origin = from, .direction = (to - from).normalized(), .t_max = kInfinity, .flags = kHitPartlyTransparent};
        const accel::Hit hit = world->accelerator().intersect(ray);
        ASSERT_TRUE(hit.is_hit());
        SurfacePoint surface;
        world->surface_at(ray, hit, surface);
        blocked += surface.unlit ? 1 : 0;
        if (!surface.has_thin_wall()) continue;
        ++passed;
        const V3f front = offset_ray_origin(surface, V3f(1, 0, 0)), back = offset_ray_origin(surface, V3f(-1, 0, 0));
        EXPECT_GT(planes.height(front), 0.0);
        EXPECT_GT(planes.height(back), 0.0) << "ray " << i << " at distance " << distance;
        EXPECT_GT(front.x, center.x);
        EXPECT_LT(back.x, center.x);
      }
      EXPECT_GT(passed, 10000);
      EXPECT_LT(blocked, 20);
    }
}

// Accelerators round origins to the space of an instance. There, too, they are inside: an origin on
// a wall would meet it at a distance of 0, which is no hit.
TEST(RayOrigins, StayInsideOfTransformedBoxesInTheirOwnSpace) {
  for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree})
    for (const float distance : {0.0f, 1000.0f, 10000.0f}) {
      const V3f c = center_at(distance);
      Scene scene = make_scene({diffuse_material(Rgb(1.0f))}, {box_walls(M44f())});
      scene.nodes[0].local.translation = c;
      animate_turn(scene, 0, V3f(0, 1, 0), 20.0f);
      animate(scene, 0, AnimatedProperty::translation, {0, 1}, {c.x, c.y, c.z, c.x + 0.5f, c.y + 0.5f, c.z + 0.5f});
      const auto world = make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, kind);
      ASSERT_TRUE(world->has_motion);
      const auto highest = [](const V3f& p) { return std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)}); };
      Numbers u;
      int on_walls = 0, ended = 0;
      for (int i = 0; i < 40000; ++i) {
        const float time = u();
        const M44f box = accel::matrix_at(world->motions[world->instances[0].motion], time);
        accel::RayToObject to_box;
        ASSERT_TRUE(to_box.set_inverse_of(box));
        accel::Ray ray = ray_to_edge(V3f(0.0f), M44f(), u);
        // Along a wall and onto another one, where a probe passes closely.
        const auto along = static_cast<int>(u() * 3.0f);
        ray.origin[along] = u.between(0.9f, 0.9999f) * (u() < 0.5f ? -1.0f : 1.0f);
        V3f to = ray.origin;
        to[(along + 1) % 3] = 1.0f;
        to[(along + 2) % 3] = u.between(-0.9f, 0.9f);
        to[along] = std::copysign(1.0f - u() * u() * 1e-6f * distance, ray.origin[along]);
        ray.origin = transform_point(box, ray.origin);
        ray.direction = (transform_point(box, to) - ray.origin).normalized();
        ray.time = time;
        // Inside for Embree, too, which rounds in another way.
        if (highest(to_box(ray).origin) >= 1.0f - 2e-7f * distance) continue;
        const accel::Hit hit = world->accelerator().intersect(ray);
        if (!hit.is_hit()) continue; // beyond the edge by rounding
        SurfacePoint surface;
        world->surface_at(ray, hit, surface);
        // Along the wall that it hits: within the rounding of a normal in world space.
        if (std::abs(surface.geometric_normal.dot(ray.direction)) < 1e-3f) continue;
        accel::Ray plain = ray;
        plain.origin = origin_beside(surface, false);
        on_walls += highest(to_box(plain).origin) >= 1.0f ? 1 : 0;
        ended += surface.unlit ? 1 : 0;
        if (surface.unlit) continue;
        accel::Ray next = ray;
        next.origin = offset_ray_origin(surface, surface.geometric_normal);
        EXPECT_LT(highest(to_box(next).origin), 1.0f) << "ray " << i << " at distance " << distance;
      }
      EXPECT_LT(ended, 40);
      EXPECT_TRUE(distance == 0.0f || on_walls > 20) << on_walls; // the test is about something
    }
}

// Nothing rises above the triangles of a convex body, so their origins are plain offsets to the
// bit.
TEST(RayOrigins, ArePlainOffsetsWhereNothingIsInTheWay) {
  for (const accel::Kind kind : {accel::Kind::embree, accel::Kind::kdtree}) // the oracle is slow
    for (const V3f& center : {V3f(0.0f), V3f(30, -20, 10)}) {
      const auto world = make_world(make_scene({diffuse_material(Rgb(1.0f))}, {sphere(center, 1.0f, 256, 0)}), kind);
      Numbers u;
      int guarded = 0;
      for (int i = 0; i < 20000; ++i) {
        const V3f side = V3f(u.between(-1, 1), u.between(-1, 1), u.between(-1, 1));
        const V3f from = center + side.normalized() * 3.0f;
        const V3f to = center + V3f(u.between(-0.6f, 0.6f), u.between(-0.6f, 0.6f), u.between(-0.6f, 0.6f));
        const accel::Ray ray{.origin = from, .direction = (to - from).normalized(), .t_max = kInfinity};
        const accel::Hit hit = world->accelerator().intersect(ray);
        if (!hit.is_hit()) continue;
        SurfacePoint surface;
        world->surface_at(ray, hit, surface);
        guarded += surface.guarded ? 1 : 0;
        EXPECT_FALSE(surface.unlit);
        EXPECT_EQ(offset_ray_origin(surface, surface.geometric_normal), origin_beside(surface, false));
      }
      EXPECT_GT(guarded, 20);
    }
}

// A quarter of the lights are infinitely far away; the distance of some others is zero.
TEST(RayOrigins, EightHaveTheBitsOfEach) {
  Numbers u;
  const auto vector = [&u] { return V3f(u.between(-1, 1), u.between(-1, 1), u.between(-1, 1)); };
  for (int i = 0; i < 20'000; ++i) {
    LaneVectors positions, normals, directions, light_normals;
    LaneNumbers errors, distances;
    std::array<SurfacePoint, Lanes::kCount> surfaces;
    std::array<LightSample, Lanes::kCount> lights;
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      SurfacePoint& surface = surfaces[lane];
      surface.position = vector() * 10.0f, surface.position_error = u() * 1e-5f;
      surface.geometric_normal = vector().normalized();
      const float distance = u() < 0.25f ? kInfinity : u() < 0.1f ? 0.0f : u() * 5.0f;
      lights[lane] = {.wi = vector().normalized(), .distance = distance};
      if (u() < 0.5f) lights[lane].normal = vector().normalized();
      positions.set(lane, surface.position), normals.set(lane, surface.geometric_normal);
      directions.set(lane, lights[lane].wi), light_normals.set(lane, lights[lane].normal);
      errors[lane] = surface.position_error, distances[lane] = distance;
    }
    const LaneMask beyond = directions.load().dot(normals.load()) < 0.0f;
    const auto origins = origin_beside<Lanes>(positions.load(), errors.load(), normals.load(), beyond);
    const WayToLight<Lanes> ways =
        way_to_light(positions.load(), origins, directions.load(), distances.load(), light_normals.load());
    for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
      const accel::Ray alone = make_shadow_ray(surfaces[lane], lights[lane], 1, 2, 0.5f);
      ASSERT_TRUE(same_bits(lane_of(origins, lane), alone.origin)) << distances[lane];
      ASSERT_TRUE(same_bits(lane_of(ways.direction, lane), alone.direction)) << distances[lane];
      ASSERT_TRUE(same_bits(ways.length[lane], alone.t_max)) << distances[lane];
    }
  }
}

} // namespace
} // namespace kindling::test
