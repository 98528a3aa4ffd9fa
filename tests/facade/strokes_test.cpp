// Points and lines in images: their width, and how they are shaded.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/render_stage.h"
#include "renderer/import/document/stroke_lists.h"
#include "renderer/scene/strokes.h"
#include "tests/integrator/test_scenes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

namespace kindling::test {
namespace {

Primitive strokes(const std::vector<V3f>& positions, int mode, std::optional<V3f> normal = {}) {
  std::vector<uint32_t> indices(positions.size());
  std::iota(indices.begin(), indices.end(), 0U);
  gltf::StrokeList list = gltf::make_strokes(indices, static_cast<uint32_t>(positions.size()), mode);
  Primitive primitive;
  primitive.material = 0;
  primitive.indices = std::move(list.indices);
  for (const uint32_t from : list.gather) primitive.positions.push_back(positions[from]);
  primitive.stroke_offsets = gltf::stroke_offsets(primitive.positions, mode);
  primitive.stroke = normal ? Stroke::lit : Stroke::unlit;
  if (normal) primitive.normals.assign(primitive.positions.size(), *normal);
  return primitive;
}

class NoMessages final : public ProgressListener {
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view) override {}
  void on_info(std::string_view) override {}
};

ImageSettings front_image(float distance) {
  ImageSettings image;
  image.size_px = V2i(64, 64);
  image.spp = 16;
  image.integrator.transparent_background = true;
  PlacedCamera camera;
  camera.camera.yfov_rad = 2.0f * std::atan(0.5f); // the image is as wide as the distance
  camera.camera_to_world = look_at(V3f(0.0f, 0.0f, distance), V3f(0.0f));
  image.own_camera = camera;
  return image;
}

Film film_of(Scene scene, const ImageSettings& image, const WorldSettings& world) {
  const std::unique_ptr<RenderScene> taken = take_render_scene(std::move(scene), world).value();
  PosedImage posed = pose_image(*taken, image).value();
  NoMessages none;
  const RenderStage stage = build_stage(*taken, std::move(posed), image, false, nullptr, none).value();
  return render(*stage.world, *stage.camera, to_render_settings(image, stage.size_px), nullptr, nullptr).value().film;
}

TEST(Strokes, WidthsArePixelsAtTheCamera) {
  Scene scene = make_scene({Material{}}, {strokes({V3f(0.5f, 0.0f, 0.0f), V3f(0.0f, 1.0f, -6.0f)}, gltf::kModeLines)});
  scene.nodes[0].local.scale = V3f(2.0f, 1.0f, 0.25f);
  scene.nodes[0].local.translation = V3f(0.0f, 0.0f, 1.0f);
  const std::vector<V3f> before = scene.meshes[0].primitives[0].positions;
  const PosedScene rest = pose_scene(scene, {}).value();
  StrokeView view;
  view.camera_to_world = look_at(V3f(0.0f, 0.0f, 5.0f), V3f(0.0f));
  view.pixel = 0.01f;
  size_strokes(scene, rest, view, 3.0f);
  const Primitive& sized = scene.meshes[0].primitives[0];
  EXPECT_TRUE(sized.stroke_offsets.empty());
  EXPECT_FALSE(has_strokes(scene));
  for (size_t v = 0; v < sized.positions.size(); ++v) {
    const V3f from = transform_point(rest.meshes[0].mesh_to_world, before[v]);
    const V3f to = transform_point(rest.meshes[0].mesh_to_world, sized.positions[v]);
    EXPECT_NEAR((to - from).length(), 0.5f * 3.0f * 0.01f * (5.0f - from.z), 1e-5f) << v;
  }
}

class WarningLines final : public ProgressListener {
 public:
  std::vector<std::string> lines;

 private:
  void on_progress(const ProgressSnapshot&) override {}
  void on_warning(std::string_view line) override { lines.emplace_back(line); }
  void on_info(std::string_view) override {}
};

TEST(Strokes, OutlinesAreShownIfAskedFor) {
  Primitive lines = strokes({V3f(-1.0f, 0.0f, 0.0f), V3f(1.0f, 0.0f, 0.0f)}, gltf::kModeLines);
  lines.outline = true;
  const Scene scene = make_scene({Material{}}, {strokes({V3f(0.0f, 1.0f, 0.0f)}, gltf::kModePoints), std::move(lines)});
  for (const bool shown : {false, true}) {
    WorldSettings world;
    world.outlines = shown;
    const std::unique_ptr<RenderScene> taken = take_render_scene(scene, world).value();
    WarningLines warnings;
    const ImageSettings image = front_image(4.0f);
    const RenderStage stage =
        build_stage(*taken, pose_image(*taken, image).value(), image, false, nullptr, warnings).value();
    EXPECT_EQ(stage.world->statistics().accelerator.triangle_count, shown ? 24U : 8U);
    const auto reported = std::count_if(warnings.lines.begin(), warnings.lines.end(),
                                        [](const std::string& line) { return line.find("--outlines") != line.npos; });
    EXPECT_EQ(reported, shown ? 0 : 1);
  }
}

TEST(Strokes, UnlitPointsShowTheirColorAndEmission) {
  Material material;
  material.base_color_factor = V4f(0.25f, 0.5f, 0.75f, 1.0f);
  material.emissive_factor = Rgb(1.0f, 0.0f, 0.0f);
  WorldSettings world;
  world.point_size_px = 40.0;
  world.studio = Studio::off;
  const Film film =
      film_of(make_scene({material}, {strokes({V3f(0.0f)}, gltf::kModePoints)}), front_image(4.0f), world);
  const std::vector<float> rgb = film.resolve(Aov::beauty), alpha = film.resolve(Aov::alpha);
  float covered = 0.0f;
  for (size_t i = 0; i < alpha.size(); ++i) {
    covered += alpha[i];
    if (alpha[i] < 1.0f) continue;
    EXPECT_FLOAT_EQ(rgb[3 * i], 1.25f);
    EXPECT_FLOAT_EQ(rgb[3 * i + 1], 0.5f);
    EXPECT_FLOAT_EQ(rgb[3 * i + 2], 0.75f);
  }
  // An octahedron of radius 20 pixels: a square of that half diagonal, a little larger in
  // perspective.
  EXPECT_NEAR(covered, 2.0f * 20.0f * 20.0f, 40.0f);
}

TEST(Strokes, LitPointsAreShadedByTheirNormal) {
  const V3f normal = V3f(0.6f, 0.0f, 0.8f);
  Scene scene = make_scene({diffuse_material(Rgb(0.5f))}, {strokes({V3f(0.0f)}, gltf::kModePoints, normal)});
  PunctualLight sun;
  sun.kind = PunctualLight::Kind::directional;
  sun.intensity = 2.0f;
  scene.lights.push_back(sun);
  Node node;
  node.light = 0; // shines along -z
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  WorldSettings world;
  world.point_size_px = 40.0;
  const Film film = film_of(scene, front_image(4.0f), world);
  const std::vector<float> rgb = film.resolve(Aov::beauty), alpha = film.resolve(Aov::alpha);
  int full = 0;
  for (size_t i = 0; i < alpha.size(); ++i) {
    if (alpha[i] < 1.0f) continue;
    ++full;
    EXPECT_NEAR(rgb[3 * i], 0.5f / kPi * 2.0f * 0.8f, 1e-4f) << i; // all facets alike, none in the shadow of another
  }
  EXPECT_GT(full, 600);
}

TEST(Strokes, LinesAreAsWideAsAskedAndFollowTheirNode) {
  WorldSettings world;
  world.point_size_px = 8.0;
  world.studio = Studio::off;
  const auto covered = [&](float shift) {
    Scene scene =
        make_scene({Material{}}, {strokes({V3f(-4.0f, 0.0f, 0.0f), V3f(4.0f, 0.0f, 0.0f)}, gltf::kModeLineStrip)});
    AnimationChannel away;
    away.node = 0;
    away.times_s = {0.0f, 1.0f};
    away.values = {0.0f, 0.0f, 0.0f, 0.0f, 0.0f, shift};
    scene.animations.push_back({"", {away}});
    ImageSettings image = front_image(4.0f);
    image.time_s = 1.0;
    const std::vector<float> alpha = film_of(scene, image, world).resolve(Aov::alpha);
    return std::accumulate(alpha.begin(), alpha.end(), 0.0f) / 64.0f;
  };
  EXPECT_NEAR(covered(0.0f), 8.0f, 1.5f);                  // between the side of the square section and its diagonal
  EXPECT_NEAR(covered(-4.0f), 0.5f * covered(0.0f), 0.4f); // a body, sized once: half as wide at twice the distance
}

} // namespace
} // namespace kindling::test
