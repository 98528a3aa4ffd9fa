// Light paths: known answers, bounce limits, lenses, media.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/integrator/light_paths/casters.h"
#include "renderer/integrator/light_paths/light_paths.h"
#include "tests/integrator/motion_scenes.h"
#include "tests/integrator/place_light.h"
#include "tests/light/light_fixtures.h"
#include "tests/session/same_bits.h"

namespace kindling::test {
namespace {

PunctualLight lamp(float intensity, float radius = 0.0f) {
  PunctualLight light;
  light.intensity = intensity;
  light.radius_m = radius;
  return light;
}

// A sphere over a floor, below a lamp.
Scene sphere_under_lamp(const Material& material, float lamp_radius = 0.0f) {
  Scene scene = make_scene({diffuse_material(Rgb(0.7f)), material},
                           {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 64, 1)});
  place_light(scene, lamp(20.0f, lamp_radius), look_at(V3f(0.5f, 6, 0.5f), V3f(0.0f)));
  return scene;
}

Camera camera_of_sphere(float f_stop = 0.0f, float cats_eye = 0.0f) {
  SceneCamera camera;
  camera.yfov_rad = 0.6f;
  if (f_stop > 0.0f) {
    camera.lens.f_stop = f_stop;
    camera.lens.cats_eye = cats_eye;
    camera.lens.focus_distance_m = 6.0f;
  }
  return {camera, look_at(V3f(0, 4, 7), V3f(0, 0.3f, 0)), V2i(48, 32)};
}

RenderSettings settings_of_sphere(float light_paths, uint32_t samples) {
  RenderSettings settings = small_render(V2i(48, 32), samples);
  settings.integrator.light_paths = light_paths;
  settings.filter = PixelFilter({FilterKind::box});
  return settings;
}

Film render_film(const World& world, const Camera& camera, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok()) << outcome.error().message;
  EXPECT_EQ(outcome.value().statistics.rays.non_finite, 0U);
  return std::move(outcome).value().film;
}

double mean_luminance(const Film& film) {
  const std::vector<float> rgb = film.resolve(Aov::beauty);
  double sum = 0.0;
  for (size_t i = 0; i < rgb.size(); i += 3) sum += static_cast<double>(luminance({rgb[i], rgb[i + 1], rgb[i + 2]}));
  return sum / (static_cast<double>(rgb.size()) / 3.0);
}

// A sun without a size and a mirror beside a floor: the floor is lit twice, which no path from the
// camera can find. A lens's barrel that hides most of it towards the corners keeps the brightness.
TEST(LightPaths, MirrorDoublesTheSun) {
  const float rho = 0.6f, irradiance = 3.0f;
  for (const char* const kind : {"pinhole", "orthographic", "cat's eye"}) {
    Scene scene = make_scene(
        {diffuse_material(Rgb(rho)), metal_material(Rgb(1.0f), 0.0f)},
        {quad(V3f(-2, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), quad(V3f(-2, 0, 3), V3f(0, 0, -6), V3f(0, 3, 0), 1)});
    PunctualLight sun;
    sun.kind = PunctualLight::Kind::directional;
    sun.intensity = irradiance;
    place_light(scene, sun, look_at(V3f(5, 5, 0), V3f(0.0f)));
    const auto world = make_world(std::move(scene), accel::Kind::kdtree);
    SceneCamera narrow;
    narrow.yfov_rad = 0.15f;
    if (std::string(kind) == "cat's eye") {
      narrow.lens.f_stop = 2.0f;
      narrow.lens.focus_distance_m = 5.2f;
      narrow.lens.cats_eye = 1.0f;
    }
    const M44f above = look_at(V3f(0, 5, 1), V3f(-1, 0, 0));
    const Camera camera = std::string(kind) == "orthographic"
                              ? beam_camera(V3f(0, 5, 1), V3f(-1, 0, 0), 0.8f, V2i(16, 16))
                              : Camera(narrow, above, V2i(16, 16));
    RenderSettings settings = small_render(V2i(16, 16), camera.has_lens() ? 4096 : 1024);
    settings.integrator.light_paths = 1.0f;
    const Film film = render_film(*world, camera, settings);
    const double expected = 2.0 * rho * irradiance * std::sqrt(0.5) / std::numbers::pi;
    Estimate pixels, corners; // of 5 x 5 pixels
    const std::vector<float> rgb = film.resolve(Aov::beauty);
    for (size_t i = 0; i < rgb.size(); ++i) {
      const size_t x = i / 3 % 16, y = i / 48;
      pixels.add(static_cast<double>(rgb[i]));
      if ((x < 5 || x > 10) && (y < 5 || y > 10)) corners.add(static_cast<double>(rgb[i]));
    }
    EXPECT_NEAR(pixels.mean(), expected, 5.0 * pixels.standard_error()) << kind;
    EXPECT_NEAR(corners.mean(), expected, 5.0 * corners.standard_error()) << kind;
    EXPECT_LT(pixels.standard_error(), 0.006 * expected) << kind;
    EXPECT_LT(corners.standard_error(), 0.01 * expected) << kind;
  }
}

// Light through the sphere takes two transmissions, the last of which needs no further bounce. Only
// light paths find this lamp.
TEST(LightPaths, KeepBounceLimits) {
  const auto world = make_world(sphere_under_lamp(glass_material(0.0f)), accel::Kind::kdtree);
  const auto light_found = [&](int max_diffuse, int max_glossy, int max_transmission) {
    RenderSettings settings = settings_of_sphere(0.0f, 4);
    settings.integrator.max_diffuse_bounces = max_diffuse;
    settings.integrator.max_glossy_bounces = max_glossy;
    settings.integrator.max_transmission_bounces = max_transmission;
    const double without = mean_luminance(render_film(*world, camera_of_sphere(), settings));
    settings.integrator.light_paths = 1.0f;
    return mean_luminance(render_film(*world, camera_of_sphere(), settings)) - without;
  };
  const double focused = light_found(1, 0, 1);
  EXPECT_GT(focused, 0.001);
  EXPECT_NEAR(light_found(1, 0, 8), focused, 1e-6); // more transmissions need reflections inside of the sphere
  EXPECT_GT(light_found(1, 4, 8), focused + 1e-6);
  EXPECT_EQ(light_found(0, 4, 8), 0.0);
  const double reflected = light_found(1, 0, 0); // by the outside of the sphere
  EXPECT_GT(reflected, 1e-4);
  EXPECT_LT(reflected, 0.5 * focused);
}

// Both estimates of the same light; images of several seeds give the standard errors.
void expect_agreement(const Material& material, const Camera& camera, const std::string& name, uint32_t samples = 64) {
  const auto world = make_world(sphere_under_lamp(material, 0.4f), accel::Kind::kdtree);
  std::array<Estimate, 3> means[2];
  for (const bool light_paths : {false, true})
    for (uint32_t seed = 0; seed < 16; ++seed) {
      RenderSettings settings = settings_of_sphere(light_paths ? 0.5f : 0.0f, samples);
      settings.seed = seed + (light_paths ? 100 : 0);
      const std::vector<float> rgb = render_film(*world, camera, settings).resolve(Aov::beauty);
      for (size_t channel = 0; channel < 3; ++channel) {
        double sum = 0.0;
        for (size_t i = channel; i < rgb.size(); i += 3) sum += static_cast<double>(rgb[i]);
        means[light_paths ? 1 : 0][channel].add(sum / (static_cast<double>(rgb.size()) / 3.0));
      }
    }
  for (size_t channel = 0; channel < 3; ++channel) {
    const Estimate &without = means[0][channel], &with = means[1][channel];
    const double error = std::hypot(without.standard_error(), with.standard_error());
    EXPECT_NEAR(without.mean(), with.mean(), 4.5 * error) << name << ", channel " << channel;
    EXPECT_LT(error, 0.005 * without.mean()) << name;
  }
}

TEST(LightPaths, AgreeThroughALens) {
  expect_agreement(glass_material(0.2f), camera_of_sphere(1.0f), "glass");
  expect_agreement(glass_material(0.2f), camera_of_sphere(1.0f, 1.5f), "a cat's eye");
}

TEST(LightPaths, AgreeAtCoats) {
  Material coated = diffuse_material(Rgb(0.8f, 0.2f, 0.2f));
  coated.clearcoat_factor = 1.0f;
  coated.clearcoat_roughness_factor = 0.1f;
  coated.sheen_color_factor = Rgb(0.5f);
  coated.sheen_roughness_factor = 0.5f;
  expect_agreement(coated, camera_of_sphere(), "coat");
  expect_agreement(glossy_material(Rgb(0.2f, 0.3f, 0.8f), 0.1f), camera_of_sphere(), "glossy");
}

TEST(LightPaths, AgreeAtPrisms) {
  for (const float roughness : {0.0f, 0.2f}) {
    Material prism = glass_material(roughness);
    prism.dispersion = 3.0f;
    expect_agreement(prism, camera_of_sphere(), "prism", 224);
  }
}

// The light of a lamp without a size, which light paths alone find, while sphere, lamp and camera
// move: the mean of static images at jittered times, by quarters of the image.
TEST(LightPaths, AreBlurredLikeAllLight) {
  Scene scene = make_scene({diffuse_material(Rgb(0.7f)), glass_material(0.0f)},
                           {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 64, 1)});
  Node lit;
  lit.light = 0;
  scene.lights.push_back(lamp(20.0f));
  scene.nodes.push_back(lit);
  scene.scenes[0].nodes.push_back(2);
  animate(scene, 2, AnimatedProperty::translation, {0, 1}, {0.5f, 6, 0.5f, -1.0f, 5, 1.5f});
  add_morph(scene, 1, [](const V3f& p) { return V3f(0.3f * p.x, 0, 0); });
  animate(scene, 1, AnimatedProperty::translation, {0, 1}, {-0.8f, 0, 0, 0.6f, 0.3f, 0.4f});
  const V3f from(0, 4, 7), to(0.7f, 4.4f, 6.5f);
  const auto placed = [](const V3f& eye) { return look_at(eye, eye - V3f(0, 3.7f, 7)); };
  SceneCamera pinhole;
  pinhole.yfov_rad = 0.6f;
  const std::vector<M44f> later{placed(to)};
  const V2i size(48, 32);
  using Quarters = std::array<double, 4>;
  const auto found_light = [&](const World& world, const Camera& camera, uint32_t samples, uint32_t seed) {
    RenderSettings settings = settings_of_sphere(0.0f, samples);
    settings.seed = seed;
    settings.guiding = Guiding::off;
    const std::vector<float> without = render_film(world, camera, settings).resolve(Aov::beauty);
    settings.integrator.light_paths = 1.0f;
    const std::vector<float> with = render_film(world, camera, settings).resolve(Aov::beauty);
    Quarters sums{};
    for (size_t i = 0; i < with.size(); ++i)
      sums[i / 3 % static_cast<size_t>(size.x) / 12] += static_cast<double>(with[i]) - static_cast<double>(without[i]);
    return sums;
  };
  std::array<Estimate, 4> moving, still, at_first;
  const auto add = [](const Quarters& sums, std::array<Estimate, 4>& estimates) {
    for (size_t q = 0; q < 4; ++q) estimates[q].add(sums[q]);
  };
  constexpr uint32_t kSets = 16, kTimes = 12;
  const auto world = make_posed_world(scene, {.shutter = Shutter{0.0, 1.0}}, accel::Kind::kdtree);
  const Camera camera(pinhole, placed(from), size, CameraMotion{later, true});
  for (uint32_t set = 0; set < kSets; ++set) {
    add(found_light(*world, camera, 32, set), moving);
    Quarters mean{};
    for (uint32_t i = 0; i < kTimes; ++i) {
      const uint32_t number = set * kTimes + i;
      const float time = (static_cast<float>(i) + to_unit_float(hash_u32(number + 5U))) / kTimes;
      const auto posed = make_posed_world(scene, {.time_s = static_cast<double>(time)}, accel::Kind::kdtree);
      const Camera then(pinhole, placed(from * (1.0f - time) + to * time), size);
      const Quarters sums = found_light(*posed, then, 4, 100 + number);
      for (size_t q = 0; q < 4; ++q) mean[q] += sums[q] / kTimes;
      if (i == 0) add(sums, at_first);
    }
    add(mean, still);
  }
  double change = 0.0;
  for (size_t q = 0; q < 4; ++q) {
    const double error = std::hypot(moving[q].standard_error(), still[q].standard_error());
    EXPECT_NEAR(moving[q].mean(), still[q].mean(), 5.5 * error) << "quarter " << q; // of 15 degrees of freedom
    EXPECT_LT(error, 0.05 * still[q].mean()) << "quarter " << q;
    change = std::max(change, std::abs(at_first[q].mean() / still[q].mean() - 1.0));
  }
  EXPECT_GT(change, 0.5);
}

// A prism disperses the light of a lamp without a size, which light paths alone find: the borders
// of the caustic are colored. Light by all wavelengths together keeps the lamp's gray.
TEST(LightPaths, PrismsDisperse) {
  const auto color_range = [&](float dispersion) {
    Material prism = glass_material(0.0f);
    prism.dispersion = dispersion;
    const auto world = make_world(sphere_under_lamp(prism), accel::Kind::kdtree);
    const std::vector<float> rgb =
        render_film(*world, camera_of_sphere(), settings_of_sphere(1.0f, 256)).resolve(Aov::beauty);
    float range = 0.0f;
    Rgb sum(0.0f);
    for (size_t i = 0; i < rgb.size(); i += 3) {
      const Rgb color(rgb[i], rgb[i + 1], rgb[i + 2]);
      sum += color;
      if (color.y > 0.05f) range = std::max(range, std::abs(color.x - color.z) / color.y);
    }
    EXPECT_NEAR(sum.x / sum.y, 1.0f, 0.01f);
    EXPECT_NEAR(sum.z / sum.y, 1.0f, 0.01f);
    return range;
  };
  EXPECT_LT(color_range(0.0f), 1e-4f);
  EXPECT_GT(color_range(5.0f), 2.0f); // what the camera sees through the sphere has 0.8
}

// The light of a lamp inside of glass begins in a medium: it is left to the paths from the camera.
TEST(LightPaths, LampInsideOfGlassIsNotLost) {
  Scene scene = make_scene({diffuse_material(Rgb(0.7f)), glass_material(0.0f), emissive_material(Rgb(20.0f))},
                           {quad(V3f(-4, 0, 4), V3f(8, 0, 0), V3f(0, 0, -8), 0), sphere(V3f(0, 1.2f, 0), 1.0f, 64, 1),
                            sphere(V3f(0, 1.2f, 0), 0.5f, 16, 2)});
  const auto world = make_world(std::move(scene), accel::Kind::kdtree);
  RenderSettings settings = settings_of_sphere(0.0f, 16);
  const Film without = render_film(*world, camera_of_sphere(), settings);
  settings.integrator.light_paths = 1.0f;
  expect_same_bits(without, render_film(*world, camera_of_sphere(), settings), "light paths");
}

TEST(LightPaths, ScenesWithoutCastersKeepTheirBits) {
  const auto world = make_world(sphere_under_lamp(diffuse_material(Rgb(0.5f))), accel::Kind::kdtree);
  RenderSettings settings = settings_of_sphere(0.0f, 4);
  const Film without = render_film(*world, camera_of_sphere(), settings);
  settings.integrator.light_paths = 1.0f;
  expect_same_bits(without, render_film(*world, camera_of_sphere(), settings), "light paths");
}

TEST(LightPaths, PassesAreSpreadEvenly) {
  std::vector<uint32_t> samples; // that begin a pass
  for (uint32_t sample = 0; sample < 16; ++sample) {
    const SampleRange passes = light_path_passes(0.25f, {sample, sample + 1});
    EXPECT_EQ(passes.first, samples.size());
    if (!passes.empty()) samples.push_back(sample);
    EXPECT_EQ(passes.end, samples.size());
  }
  EXPECT_EQ(samples, (std::vector<uint32_t>{0, 4, 8, 12}));
  EXPECT_EQ(light_path_passes(0.25f, {3, 14}), (SampleRange{1, 4}));
  EXPECT_EQ(light_path_passes(1.0f, {5, 9}), (SampleRange{5, 9}));
  EXPECT_TRUE(light_path_passes(0.0f, {0, 9}).empty());
}

TEST(Casters, HaveNarrowLobes) {
  Material coated = metal_material(Rgb(1.0f), 0.6f), rough_coat = metal_material(Rgb(1.0f), 0.6f),
           faint_coat = metal_material(Rgb(1.0f), 0.6f), thin = glass_material(0.0f);
  coated.clearcoat_factor = rough_coat.clearcoat_factor = 1.0f;
  rough_coat.clearcoat_roughness_factor = 0.6f;
  faint_coat.clearcoat_factor = 0.05f;
  thin.thickness_factor = 0.0f;
  const Material glossy = glossy_material(Rgb(0.5f), 0.3f);
  const std::vector<Material> materials{diffuse_material(Rgb(0.5f)),
                                        glass_material(0.1f),
                                        metal_material(Rgb(1.0f), 0.3f),
                                        metal_material(Rgb(1.0f), 0.6f),
                                        coated,
                                        rough_coat,
                                        faint_coat,
                                        thin,
                                        glossy};
  std::vector<Primitive> spheres;
  for (size_t i = 0; i < materials.size(); ++i)
    spheres.push_back(sphere(V3f(5.0f * static_cast<float>(i), 0, 0), i == 2 ? 0.5f : 1.0f, 8, static_cast<int>(i)));
  const auto world = make_world(make_scene(materials, spheres), accel::Kind::kdtree);
  const std::vector<uint8_t> casters = find_caster_materials(*world);
  EXPECT_EQ(std::vector<uint8_t>(casters.begin(), casters.begin() + 9),
            (std::vector<uint8_t>{0, 1, 1, 0, 1, 0, 0, 0, 1}));
  const std::vector<EmissionTarget> targets = find_targets(*world, casters);
  ASSERT_EQ(targets.size(), 4U);
  for (const EmissionTarget& target : targets) {
    const float place = std::round(target.center.x / 5.0f), radius = place == 2.0f ? 0.5f : 1.0f;
    EXPECT_TRUE(place == 1.0f || place == 2.0f || place == 4.0f || place == 8.0f) << place;
    EXPECT_LT((target.center - V3f(5.0f * place, 0, 0)).length(), 0.1f);
    EXPECT_GE(target.radius, radius);
    EXPECT_LE(target.radius, 1.8f * radius);
  }
}

} // namespace
} // namespace kindling::test
