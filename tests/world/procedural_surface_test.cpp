// Tests of procedural textures on surfaces: all slots, object and world space, filtering.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"
#include "tests/texture/graph_builder.h"

#include <set>

namespace kindling::test {
namespace {

using K = ProceduralKind;
using T = ProceduralType;
using GraphNode = GraphBuilder::Node;

SurfacePoint patterned_surface_below(const World& world, float x, float z, const RayFootprint& footprint = {},
                                     uint32_t index = 0) {
  const accel::Ray ray{
      .origin = V3f(x, 5, z), .t_min = 0.0f, .direction = V3f(0, -1, 0), .t_max = kInfinity, .key = 77, .index = index};
  const accel::Hit hit = world.accelerator().intersect(ray);
  EXPECT_TRUE(hit.is_hit());
  SurfacePoint surface;
  if (hit.is_hit()) world.surface_at(ray, hit, surface, footprint);
  return surface;
}

Primitive patterned_floor(int material) { return quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), material); }

void use(TextureSlot& slot, int graph) {
  slot.procedural = graph;
  slot.procedural_texcoords = 1;
}

// (0.25, 0.5, 0.75), with alpha 0.125.
ProceduralGraph constant_graph() {
  GraphBuilder g;
  return g.graph(g.add(K::constant, T::color4, {{"value", V4f(0.25f, 0.5f, 0.75f, 0.125f)}}));
}

ProceduralGraph position_graph(bool world_space) {
  GraphBuilder g;
  const GraphNode p = g.add(K::position, T::vector3);
  if (world_space) g.set_word(p, 0, 2);
  return g.graph(g.add(K::add, T::vector3,
                       {{"in1", g.add(K::multiply, T::vector3, {{"in1", p}, {"in2", 0.1f}})}, {"in2", V3f(0.5f)}}));
}

TEST(ProceduralSurface, FillsEverySlot) {
  Material material;
  material.emissive_factor = Rgb(2.0f);
  for (TextureSlot* slot : {&material.base_color_texture, &material.metallic_roughness_texture,
                            &material.emissive_texture, &material.specular_texture, &material.specular_color_texture})
    use(*slot, 0);
  Scene scene = make_scene({material}, {patterned_floor(0)});
  scene.procedurals = {constant_graph()};
  const auto world = make_world(std::move(scene), accel::Kind::embree);
  const SurfacePoint surface = patterned_surface_below(*world, 0.3f, 0.2f);
  EXPECT_EQ(surface.bsdf.base_color, Rgb(0.25f, 0.5f, 0.75f));
  EXPECT_EQ(surface.bsdf.roughness, 0.5f);
  EXPECT_EQ(surface.bsdf.metallic, 0.75f);
  EXPECT_EQ(surface.bsdf.specular, 0.125f);
  EXPECT_EQ(surface.bsdf.specular_color, Rgb(0.25f, 0.5f, 0.75f));
  EXPECT_EQ(surface.emitted, Rgb(0.5f, 1.0f, 1.5f));
  EXPECT_EQ(surface.emissive_triangle, accel::kNoId); // BSDF sampling only
  EXPECT_EQ(surface.alpha, 1.0f);
}

TEST(ProceduralSurface, SupportsCutouts) {
  Material material;
  material.alpha_mode = AlphaMode::mask;
  use(material.base_color_texture, 0);
  for (const bool opaque : {false, true}) {
    Scene scene = make_scene({material}, {patterned_floor(0)});
    GraphBuilder g;
    scene.procedurals = {opaque ? g.graph(g.add(K::constant, T::color3)) : constant_graph()};
    const auto world = make_world(std::move(scene), accel::Kind::embree);
    const accel::Ray ray{.origin = V3f(0.3f, 5, 0.2f), .t_min = 0.0f, .direction = V3f(0, -1, 0), .t_max = kInfinity};
    EXPECT_EQ(world->accelerator().intersect(ray).is_hit(), opaque);
  }
}

// The same mesh moved and rotated, alone (baked) and many times (instanced): the pattern moves
// along, or stays in the world.
TEST(ProceduralSurface, FollowsObjectOrWorldSpace) {
  for (const bool world_space : {false, true})
    for (const bool instanced : {false, true}) {
      Material material = diffuse_material(Rgb(1.0f));
      use(material.base_color_texture, 0);
      Scene scene = make_scene({material}, {patterned_floor(0)});
      scene.procedurals = {position_graph(world_space)};
      {
        kindling::Node& node = scene.nodes[0];
        node.local.translation = V3f(0.25f, 0.5f, -0.5f);
        node.local.scale = V3f(2.0f, 3.0f, 4.0f);
      }
      if (instanced) {
        // Enough triangles that copies are not baked.
        Primitive& primitive = scene.meshes[0].primitives[0];
        const std::vector<uint32_t> two = primitive.indices;
        for (int k = 0; k < 140000; ++k) primitive.indices.insert(primitive.indices.end(), {0, 0, 0});
        kindling::Node second = scene.nodes[0];
        second.local.translation.y = -3.0f;
        scene.nodes.push_back(second);
        scene.scenes[0].nodes.push_back(1);
      }
      const auto world = make_world(std::move(scene), accel::Kind::embree);
      const SurfacePoint surface = patterned_surface_below(*world, 0.75f, 0.5f);
      const V3f p = world_space ? V3f(0.75f, 0.5f, 0.5f) : V3f(0.25f, 0.0f, 0.25f);
      const Rgb expected = p * 0.1f + V3f(0.5f);
      EXPECT_LT((surface.bsdf.base_color - expected).length(), 1e-5f) << world_space << instanced;
    }
}

// A wide ray sees the mean, a narrow one the pattern; coverage and footprints of zero width do not
// depend on the ray.
TEST(ProceduralSurface, IsFilteredByFootprint) {
  Material material = diffuse_material(Rgb(1.0f));
  use(material.base_color_texture, 0);
  Scene scene = make_scene({material}, {patterned_floor(0)});
  GraphBuilder g;
  scene.procedurals = {g.graph(
      g.add(K::checkerboard, T::color3, {{"color1", V3f(0.8f)}, {"color2", V3f(0.2f)}, {"uvtiling", V2f(64.0f)}}))};
  const auto world = make_world(std::move(scene), accel::Kind::embree);
  std::set<float> narrow, wide;
  for (int k = 0; k < 64; ++k) {
    const float x = -0.9f + 0.027f * static_cast<float>(k);
    narrow.insert(patterned_surface_below(*world, x, 0.3f * x).bsdf.base_color.x);
    wide.insert(patterned_surface_below(*world, x, 0.3f * x, {.width_m = 1.0f}).bsdf.base_color.x);
  }
  EXPECT_EQ(narrow, (std::set<float>{0.2f, 0.8f}));
  for (const float value : wide) EXPECT_NEAR(value, 0.5f, 0.02f);
}

// A nonlinear function of noise: the mean over wide footprints equals that of all points, with less
// variance.
TEST(ProceduralSurface, FilteredSamplesHaveSameMean) {
  Material material = diffuse_material(Rgb(1.0f));
  use(material.base_color_texture, 0);
  Scene scene = make_scene({material}, {patterned_floor(0)});
  GraphBuilder g;
  const GraphNode p = g.add(K::multiply, T::vector3, {{"in1", g.add(K::position, T::vector3)}, {"in2", 37.0f}});
  const GraphNode n = g.add(K::noise3d, T::float_, {{"position", p}});
  const GraphNode squared = g.add(K::multiply, T::float_, {{"in1", n}, {"in2", n}});
  scene.procedurals = {g.graph(g.add(K::convert, T::color3, {{"in", squared}}))};
  const auto world = make_world(std::move(scene), accel::Kind::embree);
  double sum = 0.0, squares = 0.0, sharp = 0.0, sharp_squares = 0.0;
  constexpr int kCount = 2000;
  for (uint32_t k = 0; k < kCount; ++k) {
    const float x = to_unit_float(hash_u32(2 * k)) * 1.6f - 0.8f, z = to_unit_float(hash_u32(2 * k + 1)) * 1.6f - 0.8f;
    const double wide = patterned_surface_below(*world, x, z, {.width_m = 0.3f}, k).bsdf.base_color.x;
    const double narrow = patterned_surface_below(*world, x, z).bsdf.base_color.x;
    sum += wide, squares += wide * wide, sharp += narrow, sharp_squares += narrow * narrow;
  }
  const double variance = squares / kCount - square(static_cast<float>(sum / kCount));
  const double sharp_variance = sharp_squares / kCount - square(static_cast<float>(sharp / kCount));
  EXPECT_NEAR(sum, sharp, 4.5 * std::sqrt(sharp_variance * kCount));
  EXPECT_LT(variance, sharp_variance / 3.0); // by four points
}

} // namespace
} // namespace kindling::test
