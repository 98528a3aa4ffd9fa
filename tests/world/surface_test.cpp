// Tests of surfaces at hits (position, normals, textures, emission, error bound) and of the World.
// SPDX-License-Identifier: Apache-2.0
#include "tests/integrator/test_scenes.h"

#include "renderer/base/hash.h"
#include "renderer/world/shading_normal.h"

#include <cstring>

namespace kindling::test {
namespace {

accel::Ray ray_down(float x, float z) {
  return {.origin = V3f(x, 5, z), .t_min = 0.0f, .direction = V3f(0, -1, 0), .t_max = kInfinity};
}

SurfacePoint surface_below(const World& world, float x, float z) {
  const accel::Ray ray = ray_down(x, z);
  const accel::Hit hit = world.accelerator().intersect(ray);
  EXPECT_TRUE(hit.is_hit());
  SurfacePoint surface;
  if (hit.is_hit()) world.surface_at(ray, hit, surface);
  return surface;
}

Primitive floor_quad(int material) { return quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), material); }

// 2 x 2 texels: red, green / blue, white.
std::shared_ptr<const Image> four_texels() {
  auto image = std::make_shared<Image>();
  image->width = image->height = 2;
  image->channels = 3;
  const uint8_t texels[12] = {255, 0, 0, 0, 255, 0, 0, 0, 255, 255, 255, 255};
  image->pixels.resize(sizeof texels);
  std::memcpy(image->pixels.data(), texels, sizeof texels);
  return image;
}

TEST(Surface, PositionIsOnTriangleWithinBound) {
  const auto world = make_world(make_scene({diffuse_material(Rgb(0.5f))}, {floor_quad(0)}), accel::Kind::embree);
  for (const float x : {-0.9f, -0.3f, 0.1f, 0.77f}) {
    const SurfacePoint surface = surface_below(*world, x, 0.3f * x);
    EXPECT_NEAR(surface.position.x, x, surface.position_error);
    EXPECT_NEAR(surface.position.y, 0.0f, surface.position_error);
    EXPECT_LT(surface.position_error, 1e-5f);
    const V3f up = offset_ray_origin(surface, V3f(0, 1, 0)), down = offset_ray_origin(surface, V3f(0.1f, -1, 0));
    EXPECT_GT(up.y, 0.0f);
    EXPECT_LT(down.y, 0.0f);
  }
}

TEST(Surface, NormalsFaceViewer) {
  Primitive from_below = floor_quad(0);
  std::swap(from_below.indices[1], from_below.indices[2]);
  std::swap(from_below.indices[4], from_below.indices[5]);
  from_below.normals.assign(4, V3f(0, -1, 0));
  for (const Primitive& primitive : {floor_quad(0), from_below}) {
    const auto world = make_world(make_scene({diffuse_material(Rgb(0.5f))}, {primitive}), accel::Kind::embree);
    const SurfacePoint surface = surface_below(*world, 0.2f, 0.1f);
    EXPECT_NEAR(surface.geometric_normal.y, 1.0f, 1e-6f);
    EXPECT_NEAR(surface.shading_normal.y, 1.0f, 1e-6f);
  }
}

// The same mesh under a mirroring, nonuniform transform without shear, alone (baked) and twice
// (instanced), gives the same surface: normals by the inverse transpose, the same front side.
TEST(Surface, BakedAndInstancedAgree) {
  Material lamp = emissive_material(Rgb(1.0f));
  lamp.double_sided = false;
  Primitive slope = quad(V3f(-1, -0.5f, 1), V3f(2, 0, 0), V3f(0, 1, -2), 0);
  slope.normals.assign(4, V3f(0.1f, 0.9f, 0.4f).normalized());
  const auto world_with = [&](bool twice, float sx) {
    Scene scene = make_scene({lamp}, {slope});
    scene.nodes[0].local.scale = V3f(sx, 1.5f, 0.5f);
    scene.nodes[0].local.translation = V3f(0.25f, 0.5f, 0);
    if (twice) {
      Node far_away = scene.nodes[0];
      far_away.local.translation = V3f(100, 0, 0);
      scene.scenes[0].nodes.push_back(1);
      scene.nodes.push_back(far_away);
    }
    return make_world(std::move(scene), accel::Kind::kdtree);
  };
  for (const float sx : {2.0f, -2.0f}) {
    const SurfacePoint baked = surface_below(*world_with(false, sx), 0.3f, 0.1f);
    const SurfacePoint instanced = surface_below(*world_with(true, sx), 0.3f, 0.1f);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(baked.position[c], instanced.position[c], instanced.position_error);
      EXPECT_NEAR(baked.geometric_normal[c], instanced.geometric_normal[c], 1e-5f);
      EXPECT_NEAR(baked.shading_normal[c], instanced.shading_normal[c], 1e-5f);
    }
    // The inverse transpose of diag(sx, 1.5, 0.5) on (0.1, 0.9, 0.4).
    const V3f expected = V3f(0.1f / sx, 0.9f / 1.5f, 0.4f / 0.5f).normalized();
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(baked.shading_normal[c], expected[c], 1e-5f);
    // The front side is still up: it emits towards the ray.
    EXPECT_EQ(baked.emitted.x, 1.0f);
    EXPECT_EQ(instanced.emitted.x, 1.0f);
    EXPECT_NE(instanced.emissive_triangle, accel::kNoId);
  }
}

TEST(Surface, AppliesTextureTransforms) {
  const auto color_at = [](const TextureSlot& slot, float x, float z) {
    Material material = diffuse_material(Rgb(1.0f));
    material.base_color_texture = slot;
    Scene scene = make_scene({material}, {floor_quad(0)});
    SceneTexture texture;
    texture.image = four_texels();
    texture.filter = TextureFilter::nearest;
    scene.textures.push_back(texture);
    const auto world = make_world(std::move(scene), accel::Kind::embree);
    return surface_below(*world, x, z).bsdf.base_color;
  };
  // u runs along +x from -1 to 1, v along -z: the corner x = -1, z = 1 is uv (0, 0), the top left
  // texel.
  TextureSlot slot{.texture = 0};
  EXPECT_EQ(color_at(slot, -0.5f, 0.5f), Rgb(1, 0, 0));
  EXPECT_EQ(color_at(slot, 0.5f, 0.5f), Rgb(0, 1, 0));
  EXPECT_EQ(color_at(slot, -0.5f, -0.5f), Rgb(0, 0, 1));
  EXPECT_EQ(color_at(slot, 0.5f, -0.5f), Rgb(1, 1, 1));
  slot.offset = V2f(0.5f, 0.0f);
  EXPECT_EQ(color_at(slot, -0.5f, 0.5f), Rgb(0, 1, 0));
  slot.offset = V2f(0.0f);
  slot.scale = V2f(2.0f, 1.0f); // uv (0.25, 0.25) reads (0.5+, 0.25)
  EXPECT_EQ(color_at(slot, -0.4f, 0.5f), Rgb(0, 1, 0));
}

// Any shading normal, even one below the surface, is rotated just far enough that the mirror
// direction of wo leaves the surface; valid ones are unchanged.
TEST(Surface, ShadingNormalsReflectUpwards) {
  const auto direction = [](uint32_t i, float lowest_z) {
    const float z = lowest_z + (1.0f - lowest_z) * to_unit_float(hash_u32(2 * i));
    const float phi = 2.0f * kPi * to_unit_float(hash_u32(2 * i + 1));
    const float r = safe_sqrt(1.0f - z * z);
    return V3f(r * std::cos(phi), r * std::sin(phi), z);
  };
  const V3f up(0, 0, 1);
  int untouched = 0;
  for (uint32_t i = 0; i < 20000; ++i) {
    const V3f wo = direction(3 * i, 1e-3f), normal = direction(3 * i + 100001, -1.0f);
    const V3f turned = with_valid_reflection(normal, up, wo);
    const auto mirrored_z = [&](const V3f& n) { return 2.0f * n.dot(wo) * n.z - wo.z; };
    EXPECT_NEAR(turned.length(), 1.0f, 1e-5f);
    EXPECT_GT(turned.dot(wo), 0.0f);
    const float lowest = std::min(0.9f * wo.z, 0.01f);
    EXPECT_GE(mirrored_z(turned), lowest - 2e-6f);
    if (normal.dot(wo) > 0.0f && mirrored_z(normal) >= lowest) {
      EXPECT_EQ(turned, normal);
      ++untouched;
    } else {
      EXPECT_NEAR(mirrored_z(turned), lowest, 2e-6f); // no further than needed
    }
  }
  EXPECT_GT(untouched, 2000);
}

TEST(Surface, NormalMapTiltsTowardsTangent) {
  auto flat = std::make_shared<Image>();
  flat->width = flat->height = 1;
  flat->channels = 3;
  flat->pixels = {std::byte{230}, std::byte{128}, std::byte{220}}; // x positive, y ~ 0, z positive
  const auto normal_with = [&](float tangent_x, float w, uint8_t green) {
    Material material = diffuse_material(Rgb(1.0f));
    material.normal_texture.texture = 0;
    auto image = std::make_shared<Image>(*flat);
    image->pixels[1] = std::byte{green};
    Primitive primitive = floor_quad(0);
    primitive.normals.assign(4, V3f(0, 1, 0));
    primitive.tangents.assign(4, V4f(tangent_x, 0, 0, w));
    Scene scene = make_scene({material}, {primitive});
    SceneTexture texture;
    texture.image = image;
    scene.textures.push_back(texture);
    return surface_below(*make_world(std::move(scene), accel::Kind::embree), 0.2f, 0.2f).shading_normal;
  };
  EXPECT_GT(normal_with(1, 1, 128).x, 0.5f);
  EXPECT_LT(normal_with(-1, 1, 128).x, -0.5f);
  // Bitangent = cross(normal, tangent) * w = cross(+y, +x) * w = -z * w: green above 0.5 leans
  // there.
  EXPECT_LT(normal_with(1, 1, 230).z, -0.3f);
  EXPECT_GT(normal_with(1, -1, 230).z, 0.3f);
}

TEST(World, SharedMeshIsInstancedUnlessSmall) {
  const auto statistics = [](int copies) {
    Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {sphere(V3f(0.0f), 1.0f, 64, 0)});
    for (int i = 1; i < copies; ++i) {
      Node node = scene.nodes[0];
      node.local.translation = V3f(3.0f * static_cast<float>(i), 0, 0);
      scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
      scene.nodes.push_back(node);
    }
    return make_world(std::move(scene), accel::Kind::kdtree)->statistics();
  };
  const auto few = statistics(3), many = statistics(80), more = statistics(120);
  EXPECT_EQ(few.accelerator.instance_count, 1U); // all baked meshes
  EXPECT_EQ(many.accelerator.instance_count, 80U);
  EXPECT_EQ(more.accelerator.instance_count, 120U);
  EXPECT_EQ(many.geometry_bytes, more.geometry_bytes);
  EXPECT_EQ(few.geometry_bytes, 3 * many.geometry_bytes);
}

TEST(World, EmptySceneHasBoundsAndNoHits) {
  for (const accel::Kind kind : kAllKinds) {
    const auto world = make_world(make_scene({}, {}), kind);
    EXPECT_FALSE(world->bounds.isEmpty());
    EXPECT_FALSE(world->accelerator().intersect(ray_down(0, 0)).is_hit());
  }
}

// A node of zero size is invisible, one that flattens its mesh shows it flat; neither affects the
// other copies.
TEST(World, HandlesFlattenedInstances) {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {sphere(V3f(0.0f), 1.0f, 32, 0)});
  Node nothing = scene.nodes[0], disc = scene.nodes[0];
  nothing.local.scale = V3f(0.0f);
  disc.local.scale = V3f(1.0f, 0.0f, 1.0f);
  disc.local.translation = V3f(5, 0.25f, 0);
  scene.scenes[0].nodes = {0, 1, 2};
  scene.nodes.push_back(nothing);
  scene.nodes.push_back(disc);
  const auto world = make_world(std::move(scene), accel::Kind::embree);
  EXPECT_NEAR(surface_below(*world, 0.01f, 0.02f).position.y, 1.0f, 1e-2f);
  const SurfacePoint flat = surface_below(*world, 5.3f, 0.2f);
  EXPECT_NEAR(flat.position.y, 0.25f, 1e-6f);
  EXPECT_NEAR(flat.shading_normal.y, 1.0f, 1e-6f);
}

class Warnings final : public ProgressListener {
 public:
  std::vector<std::string> lines;
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view message) override { lines.emplace_back(message); }
  void on_info(std::string_view) override {}
};

TEST(World, DarkSceneGetsStudioWithWarning) {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {floor_quad(0)});
  PosedScene posed = pose_scene(scene, {}).value();
  Warnings warnings;
  const auto world = build_world(std::move(scene), std::move(posed), {}, nullptr, &warnings);
  ASSERT_TRUE(world.ok());
  EXPECT_TRUE(world.value()->lights.has_environment);
  ASSERT_EQ(warnings.lines.size(), 1U);
  EXPECT_NE(warnings.lines[0].find("built-in"), std::string::npos);
}

TEST(World, CancelledBuildFails) {
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {floor_quad(0)});
  PosedScene posed = pose_scene(scene, {}).value();
  CancelToken cancel;
  cancel.cancel();
  const auto world = build_world(std::move(scene), std::move(posed), {}, &cancel, nullptr);
  ASSERT_FALSE(world.ok());
  EXPECT_EQ(world.error().kind, ErrorKind::render_failed);
}

// Dark scenes get the built-in environment: a textured glow of strength 1 is not a lamp.
TEST(World, ScenesWithoutLampGetBuiltinEnvironment) {
  const auto is_lit = [](float strength, bool textured) {
    Material material = emissive_material(Rgb(1.0f));
    material.emissive_strength = strength;
    if (textured) material.emissive_texture.texture = 0;
    Scene scene = make_scene({material}, {floor_quad(0)});
    scene.textures.push_back({.image = four_texels()});
    Result<PosedScene> posed = pose_scene(scene, {});
    const Result<std::unique_ptr<const World>> world =
        build_world(std::move(scene), std::move(posed).value(), {}, nullptr, nullptr);
    return !is_black(world.value()->lights.environment_radiance(V3f(0, 1, 0)));
  };
  EXPECT_TRUE(is_lit(1.0f, true));
  EXPECT_FALSE(is_lit(2.0f, true));
  EXPECT_FALSE(is_lit(1.0f, false));
}

} // namespace
} // namespace kindling::test
