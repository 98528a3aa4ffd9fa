// Mattes and nearest samples of rendered scenes whose coverage is known.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/film/cryptomatte.h"
#include "tests/session/mixed_scene.h"
#include "tests/session/same_bits.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>

namespace kindling::test {
namespace {

const V2i kMatteSize(8, 8);
constexpr uint32_t kMatteSpp = 64;

// Orthographic, from z = 5 at the square of side 2 around the origin; no pixel sees past it.
Camera front_camera(bool shutter_open = false) {
  SceneCamera camera;
  camera.kind = SceneCamera::Kind::orthographic;
  camera.xmag = camera.ymag = 1.0f;
  return {camera, look_at(V3f(0, 0, 5), V3f(0.0f)), kMatteSize, CameraMotion{.shutter_open = shutter_open}};
}

RenderSettings matte_settings(FilterKind filter = FilterKind::box) {
  RenderSettings settings = small_render(kMatteSize, kMatteSpp);
  settings.filter = PixelFilter({.kind = filter});
  settings.integrator.transparent_background = true;
  add_mattes(settings);
  return settings;
}

Film film_of(const World& world, const RenderSettings& settings, const Camera& camera) {
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok()) << (outcome.ok() ? "" : outcome.error().message);
  return std::move(outcome).value().film;
}

Film film_of(const World& world, const RenderSettings& settings) { return film_of(world, settings, front_camera()); }

// Coverage of each pixel by a name.
std::vector<float> matte_of(const Film& film, Matte matte, const std::string& name) {
  constexpr int kLevels = 8;
  const std::vector<float> ranks = film.resolve_matte(matte, kLevels);
  std::vector<float> coverage(ranks.size() / (2 * kLevels), 0.0f);
  for (size_t i = 0; i < ranks.size(); i += 2)
    if (std::bit_cast<uint32_t>(ranks[i]) == matte_id(name)) coverage[i / (2 * kLevels)] += ranks[i + 1];
  return coverage;
}

// Sum over all ids.
std::vector<float> total_of(const Film& film, Matte matte) {
  const std::vector<float> ranks = film.resolve_matte(matte, 16);
  std::vector<float> total(ranks.size() / 32, 0.0f);
  for (size_t i = 0; i < ranks.size(); i += 2) total[i / 32] += ranks[i + 1];
  return total;
}

void expect_sums_to_alpha(const Film& film) {
  const std::vector<float> alpha = film.resolve(Aov::alpha);
  for (const MatteInfo& info : kMattes) {
    const std::vector<float> total = total_of(film, info.matte);
    for (size_t i = 0; i < alpha.size(); ++i) EXPECT_NEAR(total[i], alpha[i], 2e-6f) << info.name << " at " << i;
  }
}

float mean(const std::vector<float>& values) {
  double sum = 0.0;
  for (const float value : values) sum += static_cast<double>(value);
  return static_cast<float>(sum / static_cast<double>(values.size()));
}

Primitive square(float side, float z, int material) {
  return quad(V3f(-0.5f * side, -0.5f * side, z), V3f(side, 0, 0), V3f(0, side, 0), material);
}

TEST(MatteRender, PartialCoverageAndMisses) {
  // A square over half of the image's width in each direction; the rest is missed.
  const auto world = make_world(make_scene({diffuse_material(Rgb(0.5f))}, {square(1.1f, 0, 0)}), accel::Kind::kdtree);
  for (const FilterKind filter : {FilterKind::box, FilterKind::blackman_harris, FilterKind::mitchell}) {
    const Film film = film_of(*world, matte_settings(filter));
    expect_sums_to_alpha(film);
    const std::vector<float> matte = matte_of(film, Matte::object, "Node_0");
    // Wider filters weigh the square's border differently.
    EXPECT_NEAR(mean(matte), 0.3025f, filter == FilterKind::box ? 0.01f : 0.05f);
    EXPECT_EQ(matte[0], 0.0f);
    EXPECT_FLOAT_EQ(matte[3 * 8 + 3], 1.0f);
    EXPECT_EQ(matte_of(film, Matte::material, "Material_0"), matte);
    EXPECT_EQ(matte_of(film, Matte::asset, "Node_0"), matte);
  }
}

TEST(MatteRender, BlendedSurfacesCoverByAlpha) {
  Material veil = diffuse_material(Rgb(0.5f));
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.3f;
  const auto world = make_world(make_scene({diffuse_material(Rgb(0.5f)), veil, diffuse_material(Rgb(0.1f))},
                                           {square(4, 0, 0), square(4, 1, 1), square(4, -1, 2)}),
                                accel::Kind::kdtree);
  const Film film = film_of(*world, matte_settings());
  expect_sums_to_alpha(film);
  EXPECT_NEAR(mean(matte_of(film, Matte::object, "Node_1")), 0.3f, 0.01f);
  EXPECT_NEAR(mean(matte_of(film, Matte::object, "Node_0")), 0.7f, 0.01f);
  EXPECT_EQ(mean(matte_of(film, Matte::object, "Node_2")), 0.0f); // behind
  // The second node is below the first one: together they are all of its asset.
  for (const float coverage : matte_of(film, Matte::asset, "Node_0")) EXPECT_FLOAT_EQ(coverage, 1.0f);
  for (const float total : total_of(film, Matte::object)) EXPECT_FLOAT_EQ(total, 1.0f);
}

TEST(MatteRender, CutOutsAreNotCovered) {
  // Alpha rises from 0 to 1 across the image; the cut-off is in its middle.
  Material mask = diffuse_material(Rgb(0.5f));
  mask.alpha_mode = AlphaMode::mask;
  mask.alpha_cutoff = 0.5f;
  Primitive front = square(2, 1, 0);
  front.colors = {V4f(1, 1, 1, 0), V4f(1, 1, 1, 1), V4f(1, 1, 1, 1), V4f(1, 1, 1, 0)};
  const auto world = make_world(make_scene({mask, diffuse_material(Rgb(0.5f))}, {std::move(front), square(4, 0, 1)}),
                                accel::Kind::kdtree);
  const Film film = film_of(*world, matte_settings());
  expect_sums_to_alpha(film);
  const std::vector<float> cut = matte_of(film, Matte::object, "Node_0"),
                           back = matte_of(film, Matte::object, "Node_1");
  for (size_t i = 0; i < cut.size(); ++i) {
    EXPECT_EQ(cut[i], i % 8 < 4 ? 0.0f : 1.0f) << i;
    EXPECT_EQ(back[i], i % 8 < 4 ? 1.0f : 0.0f) << i;
  }
}

TEST(MatteRender, MovingObjectsShareThePixelsThatTheyPass) {
  // Two squares of a quarter of the image's width cross it in opposite directions, one before the
  // other.
  Scene scene =
      make_scene({diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.1f))}, {square(0.5f, 1, 0), square(0.5f, 0, 1)});
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {-0.5f, 0, 0, 0.5f, 0, 0});
  animate(scene, 1, AnimatedProperty::translation, {0, 1}, {0.5f, 0, 0, -0.5f, 0, 0});
  for (const accel::Kind kind : {accel::Kind::kdtree, accel::Kind::embree}) {
    Scene copy = scene;
    const auto world = make_posed_world(std::move(copy), {.shutter = Shutter{0.0, 1.0}}, kind, nullptr);
    const Film film = film_of(*world, matte_settings(), front_camera(true));
    expect_sums_to_alpha(film);
    const std::vector<float> front = matte_of(film, Matte::object, "Node_0");
    const std::vector<float> back = matte_of(film, Matte::object, "Node_1");
    // Each covers a point near the middle for half of the time. At x they overlap for all of it but
    // 2 |x|, when the one behind is seen.
    const auto columns = [](const std::vector<float>& matte, size_t first, size_t last) {
      float sum = 0.0f;
      for (size_t x = first; x <= last; ++x) sum += matte[3 * 8 + x] / static_cast<float>(last - first + 1);
      return sum;
    };
    EXPECT_NEAR(columns(front, 3, 4), 0.5f, 0.03f);
    EXPECT_NEAR(columns(back, 3, 4), 0.25f, 0.04f);
    EXPECT_NEAR(columns(front, 1, 1), 0.125f, 0.04f); // where they begin
    EXPECT_NEAR(columns(back, 6, 6), 0.125f, 0.04f);
    EXPECT_NEAR(mean(front), 0.0625f, 0.005f); // its area, wherever it is
  }
}

TEST(MatteRender, DepthOfFieldSpreadsCoverage) {
  SceneCamera lens;
  lens.lens.f_stop = 0.5f;
  lens.lens.focal_length_m = 0.5f;
  lens.lens.focus_distance_m = 2.0f;
  const auto world = make_world(make_scene({diffuse_material(Rgb(0.5f))}, {square(1.1f, 0, 0)}), accel::Kind::kdtree);
  const auto partly_covered = [&](const SceneCamera& camera) {
    const Film film = film_of(*world, matte_settings(), Camera(camera, look_at(V3f(0, 0, 5), V3f(0.0f)), kMatteSize));
    expect_sums_to_alpha(film);
    return std::ranges::count_if(matte_of(film, Matte::object, "Node_0"), [](float c) { return c > 0.0f && c < 1.0f; });
  };
  EXPECT_GT(partly_covered(lens), 15);
  EXPECT_LT(partly_covered({}), 15);
}

TEST(MatteRender, OtherIntegratorsHaveTheSameMattes) {
  const auto world = make_world(
      make_scene({diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.5f))}, {square(1.1f, 0, 0), square(0.7f, 1, 1)}),
      accel::Kind::kdtree);
  RenderSettings settings = matte_settings();
  const std::vector<float> path = film_of(*world, settings).resolve_matte(Matte::object, 6);
  for (const IntegratorKind kind :
       {IntegratorKind::ambient_occlusion, IntegratorKind::albedo, IntegratorKind::material}) {
    settings.integrator.kind = kind;
    EXPECT_TRUE(same_bits(film_of(*world, settings).resolve_matte(Matte::object, 6), path)) << integrator_name(kind);
  }
}

TEST(MatteRender, CostNoSample) {
  const auto world = mixed_world(accel::Kind::kdtree);
  const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 1.2f, 6), V3f(0.0f)), kMatteSize);
  RenderSettings settings = small_render(kMatteSize, 5);
  const Film without = film_of(*world, settings, camera);
  add_mattes(settings);
  settings.aovs.insert(Aov::object_id);
  EXPECT_TRUE(same_bits(film_of(*world, settings, camera).resolve_rgba(), without.resolve_rgba()));
}

std::string refusal(const World& world, const RenderSettings& settings) {
  const Result<RenderOutcome> outcome = render(world, front_camera(), settings, nullptr, nullptr);
  EXPECT_FALSE(outcome.ok());
  if (outcome.ok()) return {};
  EXPECT_EQ(outcome.error().kind, ErrorKind::usage);
  return outcome.error().message;
}

TEST(MatteRender, IsRefusedWhereItCannotBe) {
  const auto world = make_world(make_scene({diffuse_material(Rgb(0.5f))}, {square(1, 0, 0)}), accel::Kind::kdtree);
  RenderSettings settings = matte_settings();
  settings.integrator.kind = IntegratorKind::whitted;
  EXPECT_NE(refusal(*world, settings).find("--cryptomatte: not with --integrator whitted"), std::string::npos);
  settings = matte_settings();
  settings.names.reset();
  EXPECT_NE(refusal(*world, settings).find("RenderSettings::names"), std::string::npos);
}

TEST(NearestSamples, ShowOneSurface) {
  // The front square covers a little less than half of the columns, so that means would be
  // mixtures.
  Primitive front = quad(V3f(-2, -2, 1), V3f(1.9f, 0, 0), V3f(0, 4, 0), 1);
  const auto world = make_world(
      make_scene({diffuse_material(Rgb(0.5f)), diffuse_material(Rgb(0.1f))}, {square(2, 0, 0), std::move(front)}),
      accel::Kind::kdtree);
  for (const IntegratorKind kind : {IntegratorKind::path, IntegratorKind::whitted, IntegratorKind::albedo}) {
    RenderSettings settings = small_render(kMatteSize, kMatteSpp);
    settings.integrator.kind = kind;
    for (const AovInfo& info : kAovs)
      if (is_of_nearest(info.aov) && !is_motion(info.aov)) settings.aovs.insert(info.aov);
    const Film film = film_of(*world, settings);
    const std::vector<float> object = film.resolve(Aov::object_id), material = film.resolve(Aov::material_id);
    const std::vector<float> depth = film.resolve(Aov::depth_nearest), position = film.resolve(Aov::position_nearest);
    const std::vector<float> uv = film.resolve(Aov::uv);
    for (size_t i = 0; i < object.size(); ++i) {
      const bool is_front = i % 8 < 4; // the nearest of 64 samples is left of the border at x = -0.1 m
      const auto column = static_cast<float>(i % 8);
      EXPECT_EQ(object[i], is_front ? 2.0f : 1.0f) << integrator_name(kind) << " at " << i;
      EXPECT_EQ(material[i], object[i]);
      EXPECT_FLOAT_EQ(depth[i], is_front ? 4.0f : 5.0f);
      EXPECT_NEAR(position[3 * i], -0.875f + 0.25f * column, 0.05f);
      EXPECT_FLOAT_EQ(position[3 * i + 2], 5.0f - depth[i]);
      if (!is_front) {
        EXPECT_NEAR(uv[3 * i], 0.0625f + 0.125f * column, 0.025f);
      }
      EXPECT_EQ(uv[3 * i + 2], 1.0f);
    }
  }
}

TEST(NearestSamples, MayMiss) {
  const auto world = make_world(make_scene({diffuse_material(Rgb(0.5f))}, {square(0.9f, 0, 0)}), accel::Kind::kdtree);
  RenderSettings settings = small_render(kMatteSize, kMatteSpp);
  settings.aovs.insert(Aov::object_id);
  settings.aovs.insert(Aov::uv);
  const Film film = film_of(*world, settings);
  EXPECT_EQ(film.resolve(Aov::object_id)[0], 0.0f);
  EXPECT_EQ(film.resolve(Aov::uv)[2], 0.0f);
  EXPECT_EQ(film.resolve(Aov::object_id)[3 * 8 + 3], 1.0f);
}

} // namespace
} // namespace kindling::test
