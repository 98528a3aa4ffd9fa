// Frames that reuse accelerator structures equal single renders; changed geometry is rebuilt.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/world/world_sequence.h"
#include "tests/integrator/motion_scenes.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <limits>

namespace kindling::test {
namespace {

const V2i kPersistentSize(53, 37);

struct Things {
  Scene scene;
  size_t still = 0;  // static triangles, baked
  size_t placed = 0; // of the mesh that is instanced
  size_t moving = 0; // moving or deforming triangles, baked when the shutter is closed
  int veil = 0;      // a still, partly transparent material
};

size_t triangles_of(const Scene& scene, int mesh) {
  size_t count = 0;
  for (const Primitive& primitive : scene.meshes[static_cast<size_t>(mesh)].primitives)
    count += primitive.indices.size() / 3;
  return count;
}

// Still: a sphere, a floor, a lamp, a veil and a sieve. Moving: a sphere that passes through the
// still one, a plate that slides in the plane of the floor, a veil, a lamp, a strip that bends and
// a flag that is morphed. Three nodes share a mesh that is too large to be copied.
Things make_things() {
  Things things{sphere_lamp_and_veil(0.3f)};
  Scene& scene = things.scene;
  scene.meshes[0].primitives[0] = sphere(V3f(0.0f), 1.0f, 64, 0);
  things.veil = 3;
  Material sieve = diffuse_material(Rgb(0.3f, 0.7f, 0.3f));
  sieve.alpha_mode = AlphaMode::mask;
  Primitive holes = sphere(V3f(-2.0f, 0.2f, 0.5f), 0.8f, 24, 0);
  for (size_t i = 0; i < holes.positions.size(); ++i)
    holes.colors.emplace_back(1.0f, 1.0f, 1.0f, i % 3 == 0 ? 0.2f : 0.9f);
  add_object(scene, sieve, std::move(holes));
  for (int mesh = 0; mesh < static_cast<int>(scene.meshes.size()); ++mesh) things.still += triangles_of(scene, mesh);

  const auto first = static_cast<int>(scene.meshes.size());
  const auto add_moving = [&](const Material& material, Primitive primitive, const std::vector<float>& to) {
    add_object(scene, material, std::move(primitive));
    std::vector<float> values{0, 0, 0};
    values.insert(values.end(), to.begin(), to.end());
    animate(scene, static_cast<int>(scene.nodes.size()) - 1, AnimatedProperty::translation, {0, 1}, values);
  };
  add_moving(diffuse_material(Rgb(0.8f, 0.2f, 0.2f)), sphere(V3f(-1.0f, 0.5f, 0.4f), 0.5f, 20, 0), {1.4f, 0.1f, 0});
  add_moving(diffuse_material(Rgb(0.1f, 0.1f, 0.9f)), quad(V3f(-1, -1, 3), V3f(2, 0, 0), V3f(0, 0, -2), 0),
             {0.7f, 0, 0.2f});
  Material veil = scene.materials[3];
  veil.base_color_factor = V4f(0.9f, 0.8f, 0.1f, 0.4f);
  add_moving(veil, quad(V3f(-0.5f, -0.8f, 1.6f), V3f(1, 0, 0), V3f(0, 1, 0), 0), {0.6f, 0.3f, 0});
  add_moving(emissive_material(Rgb(2.0f, 6.0f, 3.0f)), quad(V3f(2, 1.5f, -1), V3f(0.5f, 0, 0), V3f(0, 0, 0.5f), 0),
             {-1, 0, 0});
  add_object(scene, diffuse_material(Rgb(0.6f)), quad(V3f(-3, -0.5f, -1), V3f(1.2f, 0, 0), V3f(0, 1.2f, 0), 0));
  add_morph(scene, static_cast<int>(scene.nodes.size()) - 1, [](const V3f& p) { return V3f(0, 0, 0.4f * p.y + 0.2f); });
  Node bent;
  bent.mesh = static_cast<int>(scene.meshes.size());
  bent.local.translation = V3f(1.5f, -0.9f, 0);
  scene.meshes.push_back({.primitives = {jointed_strip(8, 1)}});
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(bent);
  add_bending_skin(scene, static_cast<int>(scene.nodes.size()) - 1, V3f(0.6f, 0, 0.8f), 80.0f);
  for (int mesh = first; mesh < static_cast<int>(scene.meshes.size()); ++mesh)
    things.moving += triangles_of(scene, mesh);

  add_object(scene, diffuse_material(Rgb(0.5f, 0.4f, 0.2f)), sphere(V3f(0.0f), 0.4f, 400, 0));
  things.placed = triangles_of(scene, static_cast<int>(scene.meshes.size()) - 1);
  const auto placed = scene.nodes.size() - 1;
  scene.nodes[placed].local.translation = V3f(1.5f, 1.4f, 0.3f);
  for (const float x : {-1.5f, 0.2f}) {
    Node copy = scene.nodes[placed];
    copy.local.translation = V3f(x, 1.5f, -0.4f);
    scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(copy);
  }
  animate(scene, static_cast<int>(scene.nodes.size()) - 1, AnimatedProperty::translation, {0, 1},
          {0.2f, 1.5f, -0.4f, 0.6f, 1.1f, 0});
  return things;
}

struct Moment {
  double time_s;
  float veil = 0.5f; // coverage of a still thing, which animations do not change here: what a pointer would do
};

WorldOptions options_for(accel::Kind kind) {
  WorldOptions options;
  options.accelerator = kind;
  options.environment = std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f));
  options.min_persistent_triangles = 0;
  return options;
}

PosedScene pose(Scene& scene, const Moment& moment, int veil, bool shutter) {
  scene.materials[static_cast<size_t>(veil)].base_color_factor.w = moment.veil;
  PoseOptions options{.time_s = moment.time_s};
  if (shutter) options.shutter = Shutter{moment.time_s, moment.time_s + 0.1};
  Result<PosedScene> posed = pose_scene(scene, options);
  EXPECT_TRUE(posed.ok());
  return std::move(posed).value();
}

Film render_persistent(const World& world) {
  RenderSettings settings = small_render(kPersistentSize, 5);
  add_aovs_of_camera(settings);
  const Camera camera(SceneCamera{}, look_at(V3f(0.5f, 0.8f, 5.5f), V3f(0.0f)), kPersistentSize,
                      CameraMotion{.shutter_open = world.has_motion});
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  return std::move(outcome).value().film;
}

class PersistentAccelerator : public testing::TestWithParam<accel::Kind> {};

// Renders the moments one after the other, compares each with the image of that moment, and returns
// what was built for each.
std::vector<size_t> built_for(const std::vector<Moment>& moments, accel::Kind kind, bool shutter) {
  Things things = make_things();
  WorldSequence worlds;
  const WorldOptions options = options_for(kind);
  std::vector<size_t> built;
  for (size_t i = 0; i < moments.size(); ++i) {
    SCOPED_TRACE(i);
    PosedScene posed = pose(things.scene, moments[i], things.veil, shutter);
    const Result<const World*> world =
        worlds.next(things.scene, std::move(posed), options, i + 1 < moments.size(), nullptr, nullptr);
    EXPECT_TRUE(world.ok());
    built.push_back(world.value()->statistics().accelerator.built_triangle_count);
    Things alone = make_things();
    PosedScene posed_alone = pose(alone.scene, moments[i], alone.veil, shutter);
    const auto single = build_world(std::move(alone.scene), std::move(posed_alone), options, nullptr, nullptr);
    EXPECT_TRUE(single.ok());
    expect_same_bits(render_persistent(*world.value()), render_persistent(*single.value()), "frames");
  }
  return built;
}

TEST_P(PersistentAccelerator, FramesEqualSingleRenders) {
  const Things things = make_things();
  const size_t all = things.still + things.placed + things.moving;
  EXPECT_EQ(built_for({{0.0}, {0.5}, {0.25}, {1.0}}, GetParam(), false),
            (std::vector<size_t>{all, things.moving, things.moving, things.moving}));
}

// With an open shutter rigid things that move are instances, whose trees are kept as well: what
// deforms is built.
TEST_P(PersistentAccelerator, FramesWithShutterEqualSingleRenders) {
  const std::vector<size_t> built = built_for({{0.0}, {0.5}, {0.25}}, GetParam(), true);
  const size_t deforming = 2 + 16;
  EXPECT_EQ(built[1], deforming);
  EXPECT_EQ(built[2], deforming);
}

// A still thing whose opacity comes and goes.
TEST_P(PersistentAccelerator, ChangedOpacityIsRebuilt) {
  const Things things = make_things();
  const size_t again = things.still + things.moving;
  EXPECT_EQ(built_for({{0.0, 0.5f}, {0.25, 1.0f}, {0.5, 1.0f}, {0.75, 0.3f}, {1.0, 0.4f}}, GetParam(), false),
            (std::vector<size_t>{again + things.placed, again, things.moving, again, things.moving}));
}

INSTANTIATE_TEST_SUITE_P(Accelerators, PersistentAccelerator, testing::Values(accel::Kind::embree, accel::Kind::kdtree),
                         [](const auto& param) { return std::string(accel::kind_name(param.param)); });

// With the kd-tree it cannot be seen what is traced apart, not even in the plate that slides in the
// plane of the floor: of hits at the same distance the smallest ids count. (With Embree it can be,
// there: which of such hits it tells depends on its trees.)
TEST(PersistentAccelerators, DivisionOfKdTreeKeepsBits) {
  for (const bool shutter : {false, true}) {
    const auto film = [&](size_t min_triangles) {
      Things things = make_things();
      PosedScene posed = pose(things.scene, {0.4}, things.veil, shutter);
      WorldOptions options = options_for(accel::Kind::kdtree);
      options.min_persistent_triangles = min_triangles;
      return render_persistent(
          *build_world(std::move(things.scene), std::move(posed), options, nullptr, nullptr).value());
    };
    expect_same_bits(film(0), film(std::numeric_limits<size_t>::max()), "one tree");
  }
}

// Without a time nothing is traced apart, and so it is where it does not pay.
TEST(PersistentAccelerators, UsedOnlyWhereItPays) {
  const auto nodes_of = [](bool animated, size_t min_triangles) {
    Things things = make_things();
    Result<PosedScene> posed = pose_scene(things.scene, animated ? PoseOptions{.time_s = 0.5} : PoseOptions{});
    WorldOptions options = options_for(accel::Kind::kdtree);
    options.min_persistent_triangles = min_triangles;
    const auto world =
        build_world(std::move(things.scene), std::move(posed).value(), options, nullptr, nullptr).value();
    size_t persistent = 0;
    for (const accel::TriangleMesh& mesh : world->accelerator_input().meshes)
      persistent += mesh.persistent_id != 0 ? mesh.triangle_count() : 0;
    return persistent;
  };
  const Things things = make_things();
  EXPECT_EQ(nodes_of(false, 0), 0U);
  EXPECT_EQ(nodes_of(true, things.still), things.still + things.placed);
  EXPECT_EQ(nodes_of(true, things.still + 1), things.placed);
}

} // namespace
} // namespace kindling::test
