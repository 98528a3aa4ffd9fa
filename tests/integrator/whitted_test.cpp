// The Whitted tracer on scenes with closed-form solutions.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/bsdf/fresnel.h"
#include "tests/integrator/motion_scenes.h"

#include <cmath>
#include <cstring>

namespace kindling::test {
namespace {

RenderSettings whitted_render(const V2i& size_px, uint32_t spp) {
  RenderSettings settings = small_render(size_px, spp);
  settings.integrator.kind = IntegratorKind::whitted;
  settings.integrator.whitted.ambient = Rgb(0.0f);
  return settings;
}

RenderOutcome outcome_of(const World& world, const Camera& camera, const RenderSettings& settings) {
  Result<RenderOutcome> outcome = render(world, camera, settings, nullptr, nullptr);
  EXPECT_TRUE(outcome.ok());
  EXPECT_EQ(outcome.value().statistics.rays.non_finite, 0U);
  return std::move(outcome).value();
}

// Returns the radiance along a beam so narrow that all samples see the same.
Rgb beam(const World& world, const V3f& eye, const V3f& target, const WhittedSettings& whitted) {
  RenderSettings settings = whitted_render({8, 8}, 1);
  settings.integrator.whitted = whitted;
  if (!whitted.ambient) settings.integrator.whitted.ambient = Rgb(0.0f);
  return mean_of(outcome_of(world, beam_camera(eye, target, 1e-3f), settings).film).rgb;
}

void expect_near(const Rgb& seen, const Rgb& expected, float relative) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], expected[c], relative * expected[c] + 1e-7f) << "channel " << c;
}

Material plain_mirror(const Rgb& color) {
  Material material;
  material.base_color_factor = V4f(color.x, color.y, color.z, 1.0f);
  material.roughness_factor = 0.0f;
  material.double_sided = true;
  return material;
}

Material glass_material(float ior, const Rgb& attenuation, float distance_m) {
  Material material;
  material.metallic_factor = material.roughness_factor = 0.0f;
  material.transmission_factor = 1.0f;
  material.thickness_factor = 1.0f;
  material.ior = ior;
  material.attenuation_color = attenuation;
  material.attenuation_distance_m = distance_m;
  return material;
}

// A closed prism with outward faces: a convex polygon (counter-clockwise as seen from +z), extruded
// from z = -half to half.
Primitive extruded(const std::vector<V2f>& points, float half, int material) {
  Primitive primitive;
  primitive.material = material;
  const auto n = static_cast<uint32_t>(points.size());
  for (const float z : {-half, half})
    for (const V2f& p : points) primitive.positions.push_back(V3f(p.x, p.y, z));
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t j = (i + 1) % n;
    for (const uint32_t index : {i, j, n + j, i, n + j, n + i}) primitive.indices.push_back(index);
  }
  for (uint32_t i = 1; i + 1 < n; ++i)
    for (const uint32_t index : {0U, i + 1, i, n, n + i, n + i + 1}) primitive.indices.push_back(index);
  return primitive;
}

PunctualLight point_light(const Rgb& intensity) {
  PunctualLight light;
  light.kind = PunctualLight::Kind::point;
  light.color = intensity;
  light.intensity = 1.0f;
  return light;
}

void add_light(Scene& scene, const PunctualLight& light, const V3f& position) {
  Node node;
  node.light = static_cast<int>(scene.lights.size());
  node.local.translation = position;
  scene.lights.push_back(light);
  scene.scenes[0].nodes.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
}

TEST(Whitted, AmbientAndEmission) {
  const Rgb albedo(0.5f, 0.25f, 0.75f), emission(1.0f, 2.0f, 3.0f), ambient(0.2f, 0.4f, 0.6f);
  const auto world = make_world(
      make_scene({emissive_material(emission, albedo)}, {quad(V3f(-1, -1, 0), V3f(2, 0, 0), V3f(0, 2, 0), 0)}),
      accel::Kind::kdtree);
  expect_near(beam(*world, V3f(0.3f, 0.2f, 2), V3f(0.3f, 0.2f, 0), {.ambient = ambient}), emission + albedo * ambient,
              1e-6f);
}

// Unset ambient light is the environment's mean. Sampling the environment gives an open plane the
// same light.
TEST(Whitted, AmbientOfTheEnvironment) {
  const auto world =
      make_world(make_scene({diffuse_material(Rgb(0.5f))}, {quad(V3f(-1, -1, 0), V3f(2, 0, 0), V3f(0, 2, 0), 0)}),
                 accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.8f, 0.4f, 0.2f)));
  RenderSettings settings = whitted_render({8, 8}, 4);
  settings.integrator.whitted.ambient.reset();
  const Camera camera = beam_camera(V3f(0, 0, 2), V3f(0.0f), 1e-3f);
  const Rgb expected = Rgb(0.8f, 0.4f, 0.2f) * 0.5f;
  expect_near(mean_of(outcome_of(*world, camera, settings).film).rgb, expected, 1e-5f);
  settings.integrator.whitted.environment_light = true;
  settings.integrator.whitted.light_strata = 8;
  const Mean sampled = mean_of(outcome_of(*world, camera, settings).film);
  EXPECT_NEAR(sampled.luminance, luminance(expected), 5.0 * sampled.standard_error + 1e-4);
  EXPECT_GT(sampled.standard_error, 0.0);
}

TEST(Whitted, PointLightOnAPlane) {
  Scene scene =
      make_scene({diffuse_material(Rgb(0.5f, 0.6f, 0.7f))}, {quad(V3f(-5, 0, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0)});
  add_light(scene, point_light(Rgb(30.0f, 20.0f, 10.0f)), V3f(0, 3, 4));
  const auto world = make_world(std::move(scene), accel::Kind::kdtree);
  // At the origin: distance 5, cosine 3/5.
  const Rgb expected = Rgb(0.5f, 0.6f, 0.7f) * Rgb(30.0f, 20.0f, 10.0f) * (0.6f / 25.0f * kInvPi);
  expect_near(beam(*world, V3f(1, 2, 0), V3f(0.0f), {}), expected, 1e-3f);
}

// A mirror reflects a light at 45 degrees.
TEST(Whitted, MirrorShowsTheLight) {
  const Rgb color(0.9f, 0.6f, 0.3f), emission(1.0f, 2.0f, 4.0f);
  const auto world = make_world(make_scene({plain_mirror(color), emissive_material(emission)},
                                           {quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0),
                                            quad(V3f(3, 1, -1), V3f(0, 0, 2), V3f(0, 4, 0), 1)}),
                                accel::Kind::kdtree);
  const float schlick = std::pow(1.0f - std::sqrt(0.5f), 5.0f);
  const Rgb expected = (color + (Rgb(1.0f) - color) * schlick) * emission;
  expect_near(beam(*world, V3f(-1, 1, 0), V3f(0.0f), {}), expected, 1e-4f);
  expect_near(beam(*world, V3f(-1, 1, 0), V3f(0.0f), {.trace_depth = 1}), Rgb(0.0f), 0.0f);
  expect_near(beam(*world, V3f(-1, 1, 0), V3f(0.0f), {.max_reflections = 0}), Rgb(0.0f), 0.0f);
}

// A glossy mirror in a uniform environment has its radiance: the lobe's samples are weighted by its
// albedo.
TEST(Whitted, RoughMirrorInAFurnace) {
  for (const float roughness : {0.0f, 0.15f, 0.3f}) {
    Material material = plain_mirror(Rgb(1.0f));
    material.roughness_factor = roughness;
    const auto world = make_world(make_scene({material}, {quad(V3f(-1, -1, 0), V3f(2, 0, 0), V3f(0, 2, 0), 0)}),
                                  accel::Kind::kdtree, std::make_shared<Environment>(Rgb(1.0f)));
    RenderSettings settings = whitted_render({8, 8}, 16);
    settings.integrator.whitted.glossy_strata = 4;
    const Mean mean = mean_of(outcome_of(*world, beam_camera(V3f(1, 0.5f, 2), V3f(0.0f), 1e-3f), settings).film);
    // The tolerance covers multiple scattering between microfacets, which reflected rays do not
    // include.
    EXPECT_NEAR(mean.luminance, 1.0, 0.01 + 5.0 * mean.standard_error) << roughness;
  }
}

// A beam at 60 degrees through a slab of thickness d = 0.5: it is displaced by d sin(i - t) /
// cos(t), and passes two interfaces and a length of d / cos(t) in the medium.
TEST(Whitted, RefractionThroughASlab) {
  constexpr float kIor = 1.5f, kThickness = 0.5f;
  const float theta_i = kPi / 3.0f, theta_t = std::asin(std::sin(theta_i) / kIor);
  const Rgb attenuation(0.5f, 0.7f, 0.9f);
  const V3f direction(std::sin(theta_i), -std::cos(theta_i), 0);
  const V3f eye = -direction * 3.0f;
  // On the plane y = -2 the straight beam arrives at x = 2 tan i, the refracted one at a smaller x.
  const float straight = 2.0f * std::tan(theta_i);
  const float refracted = straight - kThickness * (std::tan(theta_i) - std::tan(theta_t));
  const float between = 0.5f * (straight + refracted);
  const auto world =
      make_world(make_scene({glass_material(kIor, attenuation, 1.0f), emissive_material(Rgb(1.0f, 1.0f, 1.0f)),
                             emissive_material(Rgb(7.0f))},
                            {extruded({V2f(-4, -kThickness), V2f(4, -kThickness), V2f(4, 0), V2f(-4, 0)}, 4.0f, 0),
                             quad(V3f(between - 9, -2, 3), V3f(9, 0, 0), V3f(0, 0, -6), 1),
                             quad(V3f(between, -2, 3), V3f(9, 0, 0), V3f(0, 0, -6), 2)}),
                 accel::Kind::kdtree);
  const float through = 1.0f - dielectric_fresnel(std::cos(theta_i), kIor);
  const float path = kThickness / std::cos(theta_t);
  const Rgb expected =
      Rgb(std::pow(attenuation.x, path), std::pow(attenuation.y, path), std::pow(attenuation.z, path)) *
      (through * through);
  const WhittedSettings settings{.trace_depth = 3, .max_reflections = 0};
  expect_near(beam(*world, eye, V3f(0.0f), settings), expected, 1e-4f);
  // Two rays do not reach beyond the slab.
  expect_near(beam(*world, eye, V3f(0.0f), {.trace_depth = 2, .max_reflections = 0}), Rgb(0.0f), 0.0f);
  // With reflections, the first one between the faces leaves below within a depth of 5, shifted
  // onto one of the lights. The reflection of the upper face hits nothing.
  const Rgb more = beam(*world, eye, V3f(0.0f), {.trace_depth = 5});
  const float reflected = 1.0f - through;
  const Rgb once =
      expected *
      Rgb(std::pow(attenuation.x, 2 * path), std::pow(attenuation.y, 2 * path), std::pow(attenuation.z, 2 * path)) *
      (reflected * reflected);
  expect_near(more, expected + once * (refracted + 2.0f * kThickness * std::tan(theta_t) > between ? 7.0f : 1.0f),
              1e-4f);
}

// Light enters one leg of a right-angled prism, is totally reflected by the hypotenuse, and leaves
// through the other leg.
TEST(Whitted, TotalReflectionIsExemptFromTheLimit) {
  const auto world =
      make_world(make_scene({glass_material(1.5f, Rgb(1.0f), 1.0f), emissive_material(Rgb(2.0f, 3.0f, 4.0f))},
                            {extruded({V2f(0, 0), V2f(1, 0), V2f(0, 1)}, 2.0f, 0),
                             quad(V3f(-1, -1, 3), V3f(3, 0, 0), V3f(0, 0, -6), 1)}),
                 accel::Kind::kdtree);
  const float through = 1.0f - square(0.5f / 2.5f);
  const V3f eye(-2, 0.4f, 0), target(0, 0.4f, 0);
  expect_near(beam(*world, eye, target, {.trace_depth = 4, .max_reflections = 0}),
              Rgb(2.0f, 3.0f, 4.0f) * (through * through), 1e-4f);
}

// Between two mirrors a camera ray is followed by one ray per level, up to the lower of both
// limits.
TEST(Whitted, TraceDepthCountsRays) {
  const auto world =
      make_world(make_scene({plain_mirror(Rgb(0.9f))}, {quad(V3f(-50, -50, 0), V3f(100, 0, 0), V3f(0, 100, 0), 0),
                                                        quad(V3f(-50, -50, 2), V3f(100, 0, 0), V3f(0, 100, 0), 0)}),
                 accel::Kind::kdtree);
  const Camera camera = beam_camera(V3f(0, 0, 1), V3f(0.1f, 0, 0), 1e-3f);
  for (const int depth : {1, 2, 5, 12})
    for (const int reflections : {0, 3, 64}) {
      RenderSettings settings = whitted_render({8, 8}, 1);
      settings.integrator.whitted.trace_depth = depth;
      settings.integrator.whitted.max_reflections = reflections;
      const RayCounters rays = outcome_of(*world, camera, settings).statistics.rays;
      EXPECT_EQ(rays.camera, 64U);
      EXPECT_EQ(rays.bounce, 64U * static_cast<unsigned>(std::min(depth - 1, reflections))) << depth;
      EXPECT_EQ(rays.whitted.reflection, rays.bounce);
      EXPECT_EQ(rays.shadow, 0U);
    }
}

// A square lamp of side 2 at a height of 4, and a half plane (x < 0) at half that height: as seen
// from the floor at x, the lamp is hidden up to -x. At most one of n columns of strata is partly
// hidden, so the fraction is off by less than 1 / n.
TEST(Whitted, PenumbraOfASquareLamp) {
  Material lamp = emissive_material(Rgb(1.0f));
  const auto plane = [&](bool shaded) {
    std::vector<Primitive> parts{quad(V3f(-9, 0, 9), V3f(18, 0, 0), V3f(0, 0, -18), 0),
                                 quad(V3f(-1, 4, -1), V3f(2, 0, 0), V3f(0, 0, 2), 1)};
    if (shaded) parts.push_back(quad(V3f(-30, 2, -30), V3f(30, 0, 0), V3f(0, 0, 60), 2));
    return make_world(make_scene({diffuse_material(Rgb(0.5f)), lamp, diffuse_material(Rgb(0.0f))}, parts),
                      accel::Kind::kdtree);
  };
  const auto open = plane(false), shaded = plane(true);
  for (const int n : {1, 4, 8}) {
    for (const float x : {-1.5f, -1.01f, -0.6f, 0.0f, 0.3f, 0.99f, 1.01f, 2.0f}) {
      const V3f eye(x, 1.5f, 0.0f), target(x, 0.0f, 0.0f);
      RenderSettings settings = whitted_render({8, 8}, 1);
      settings.integrator.whitted.light_strata = n;
      SceneCamera orthographic;
      orthographic.kind = SceneCamera::Kind::orthographic;
      orthographic.xmag = orthographic.ymag = 1e-4f;
      const Camera camera(orthographic, kindling::look_at(eye, target, V3f(0, 0, 1)), {8, 8});
      const std::vector<float> lit = outcome_of(*open, camera, settings).film.resolve(Aov::beauty);
      const std::vector<float> seen = outcome_of(*shaded, camera, settings).film.resolve(Aov::beauty);
      const float share = std::clamp(0.5f * (1.0f + x), 0.0f, 1.0f);
      for (size_t i = 0; i < seen.size(); i += 3) {
        // The lamp's corners contribute up to a fifth less than its center.
        EXPECT_NEAR(seen[i] / lit[i], share, 1.0 / n + 0.05) << n << " at " << x;
        if (x < -1.0f) {
          EXPECT_EQ(seen[i], 0.0f);
        }
        if (x > 1.0f) {
          EXPECT_EQ(seen[i], lit[i]);
        }
      }
    }
  }
}

// Direct light on diffuse surfaces is the same in both tracers: up to rounding for point lights, in
// the mean for area lights.
TEST(Whitted, AgreesWithThePathTracerOnDiffuseSurfaces) {
  for (const bool area : {false, true}) {
    Scene scene =
        make_scene({diffuse_material(Rgb(0.7f, 0.5f, 0.3f)), diffuse_material(Rgb(0.5f)), emissive_material(Rgb(4.0f))},
                   area ? std::vector<Primitive>{sphere(V3f(0.0f), 1.0f, 24, 0),
                                                 quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 1),
                                                 quad(V3f(-1, 3, -1), V3f(2, 0, 0), V3f(0, 0, 2), 2)}
                        : std::vector<Primitive>{sphere(V3f(0.0f), 1.0f, 24, 0),
                                                 quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 1)});
    if (!area) add_light(scene, point_light(Rgb(40.0f)), V3f(2, 4, 3));
    const auto world = make_world(std::move(scene), accel::Kind::kdtree);
    const Camera camera(SceneCamera{}, look_at(V3f(1.5f, 2.0f, 5.0f), V3f(0.0f)), {32, 24});
    RenderSettings settings = whitted_render({32, 24}, area ? 64 : 4);
    settings.integrator.max_bounces = settings.integrator.max_transmission_bounces = 0;
    const RenderOutcome whitted = outcome_of(*world, camera, settings);
    settings.integrator.kind = IntegratorKind::path;
    const RenderOutcome path = outcome_of(*world, camera, settings);
    const std::vector<float> a = whitted.film.resolve(Aov::beauty), b = path.film.resolve(Aov::beauty);
    if (!area) {
      for (size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], 1e-4f * b[i] + 1e-6f) << i;
    } else {
      const Mean m = mean_of(whitted.film), n = mean_of(path.film);
      EXPECT_NEAR(m.luminance, n.luminance, 4.0 * std::hypot(m.standard_error, n.standard_error));
      EXPECT_GT(n.luminance, 0.02);
    }
  }
}

// A point light with a radius is visible as a sphere in mirrors, and invisible to the camera.
TEST(Whitted, MirrorShowsALampWithASize) {
  Scene scene = make_scene({plain_mirror(Rgb(1.0f))}, {quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0)});
  PunctualLight lamp = point_light(Rgb(3.0f, 2.0f, 1.0f));
  lamp.radius_m = 0.5f;
  add_light(scene, lamp, V3f(3, 3, 0));
  const auto world = make_world(std::move(scene), accel::Kind::kdtree);
  expect_near(beam(*world, V3f(-1, 1, 0), V3f(0.0f), {}), Rgb(3.0f, 2.0f, 1.0f) * (kInvPi / 0.25f), 1e-4f);
  expect_near(beam(*world, V3f(-1, 1, 2), V3f(0, 0, 2), {}), Rgb(0.0f), 0.0f); // beside the mirror
  expect_near(beam(*world, V3f(1, 1, 0), V3f(2, 2, 0), {}), Rgb(0.0f), 0.0f);  // at the lamp
  expect_near(beam(*world, V3f(-1, 0.5f, 0), V3f(0.0f), {}), Rgb(0.0f), 0.0f); // past it
}

// An emissive plate passes through the reflection in a mirror, and an opaque one in front of a
// light, each for half of the time.
TEST(Whitted, AllRaysHaveTheTimeOfTheirSample) {
  Scene scene = make_scene(
      {plain_mirror(Rgb(1.0f)), emissive_material(Rgb(1.0f)), diffuse_material(Rgb(1.0f)), diffuse_material(Rgb(0.0f))},
      {quad(V3f(3, 1, -1), V3f(0, 0, 2), V3f(0, 4, 0), 1), quad(V3f(-1, 1.5f, 1.5f), V3f(2, 0, 0), V3f(0, 0, 1), 3),
       quad(V3f(-1, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 0), quad(V3f(19, 0, 1), V3f(2, 0, 0), V3f(0, 0, -2), 2)});
  animate(scene, 0, AnimatedProperty::translation, {0, 1}, {0, 0, -3, 0, 0, 1});
  animate(scene, 1, AnimatedProperty::translation, {0, 1}, {17, 0, 0, 21, 0, 0});
  add_light(scene, point_light(Rgb(30.0f)), V3f(20, 3, 4));
  const auto world = make_posed_world(std::move(scene), {.shutter = Shutter{0.0, 1.0}}, accel::Kind::kdtree);
  for (const WhittedForm form : {WhittedForm::iterative, WhittedForm::recursive})
    for (const bool mirror : {true, false}) {
      SceneCamera camera;
      camera.kind = SceneCamera::Kind::orthographic;
      camera.xmag = camera.ymag = 0.5e-3f;
      const V3f target(mirror ? 0.0f : 20.0f, 0, 0);
      const Camera open(camera, look_at(target + V3f(-1, mirror ? 1.0f : 3.0f, 0), target), {8, 8},
                        CameraMotion{.shutter_open = true});
      RenderSettings settings = whitted_render({8, 8}, 64);
      settings.integrator.whitted.form = form;
      settings.integrator.whitted.trace_depth = 2;
      const double full = mirror ? 1.0 : 30.0 * 0.6 / 25.0 * static_cast<double>(kInvPi);
      const double mean = mean_of(outcome_of(*world, open, settings).film).luminance;
      EXPECT_NEAR(mean / full, 0.5, 4.0 * std::sqrt(0.25 / (64 * 64))) << mirror; // of independent samples
    }
}

// Two veils with a coverage of one quarter in front of a transparent background.
TEST(Whitted, CoverageAndAlpha) {
  Material veil = diffuse_material(Rgb(0.5f));
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_factor.w = 0.25f;
  const auto world = make_world(make_scene({veil}, {quad(V3f(-1, -1, 0), V3f(2, 0, 0), V3f(0, 2, 0), 0),
                                                    quad(V3f(-1, -1, 1), V3f(2, 0, 0), V3f(0, 2, 0), 0)}),
                                accel::Kind::kdtree);
  RenderSettings settings = whitted_render({8, 8}, 1);
  settings.integrator.whitted.ambient = Rgb(1.0f);
  settings.integrator.whitted.trace_depth = 1; // straight continuations do not count
  settings.integrator.transparent_background = true;
  const Film film = outcome_of(*world, beam_camera(V3f(0, 0, 3), V3f(0.0f), 1e-3f), settings).film;
  EXPECT_NEAR(film.resolve(Aov::beauty)[0], 0.5f * (0.25f + 0.75f * 0.25f), 1e-6f);
  EXPECT_NEAR(film.resolve(Aov::alpha)[0], 1.0f - 0.75f * 0.75f, 1e-6f);
}

} // namespace
} // namespace kindling::test
