// Renderer makes the images of the command line, and serves programs that render repeatedly.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/renderer.h"

#include "renderer/image/decode_image.h"
#include "renderer/import/load_gltf.h"
#include "renderer/session/accumulation_file.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <thread>

namespace kindling::test {
namespace {

namespace fs = std::filesystem;

const fs::path kScenes = KINDLING_SCENES;

std::vector<uint32_t> bits_of(const std::vector<float>& values) {
  std::vector<uint32_t> bits;
  for (const float value : values) bits.push_back(std::bit_cast<uint32_t>(value));
  return bits;
}

class RendererTest : public SceneFolder {
 protected:
  // Returns the pixels that the command writes.
  std::vector<float> command_rgba(std::vector<std::string> flags) const {
    flags.insert(flags.begin(), "render");
    for (const char* flag : {"--exr-float", "-o", "command.exr"}) flags.emplace_back(flag);
    const ProgramResult result = run_program(flags, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    const Result<Image> image = read_image_file(folder_ / "command.exr");
    EXPECT_TRUE(image.ok()) << image.error().message;
    if (!image.ok()) return {};
    EXPECT_EQ(image.value().type, PixelType::f32);
    EXPECT_EQ(image.value().channels, 4);
    std::vector<float> rgba(image.value().pixels.size() / sizeof(float));
    std::memcpy(rgba.data(), image.value().pixels.data(), image.value().pixels.size());
    return rgba;
  }

  static Renderer load(const fs::path& file, const WorldSettings& world = {}) {
    Result<Renderer> loaded = Renderer::load(file, world);
    EXPECT_TRUE(loaded.ok()) << loaded.error().message;
    return std::move(loaded).value();
  }

  static RenderedImage render(Renderer& renderer, const ImageSettings& image, const RunOptions& run = {}) {
    Result<RenderedImage> rendered = renderer.render(image, run);
    EXPECT_TRUE(rendered.ok()) << rendered.error().message;
    return std::move(rendered).value();
  }

  static ImageSettings small_image() {
    ImageSettings image;
    image.size_px = V2i(48, 32);
    image.spp = 8;
    return image;
  }
};

TEST_F(RendererTest, SameBitsAsTheCommandInTheCornellBox) {
  Renderer renderer = load(kScenes / "cornell_box.glb");
  ImageSettings image;
  image.size_px = V2i(96, 64);
  image.spp = 16;
  image.seed = 3;
  const RenderedImage rendered = render(renderer, image);
  EXPECT_EQ(
      bits_of(rendered.film.resolve_rgba()),
      bits_of(command_rgba({(kScenes / "cornell_box.glb").string(), "--size", "96x64", "--spp", "16", "--seed", "3"})));
}

TEST_F(RendererTest, SameBitsAsTheCommandInTheInterior) {
  WorldSettings world;
  world.env_color = Rgb(0.5f, 0.6f, 0.7f);
  world.lights.radius_m = 0.05;
  Renderer renderer = load(kScenes / "interior.glb", world);
  ImageSettings image;
  image.scale = 0.05;
  image.spp = 4;
  image.lens.f_stop = 2.8;
  const RenderedImage rendered = render(renderer, image);
  EXPECT_EQ(bits_of(rendered.film.resolve_rgba()),
            bits_of(command_rgba({(kScenes / "interior.glb").string(), "--env-color", "0.5,0.6,0.7", "--light-radius",
                                  "0.05", "--scale", "0.05", "--spp", "4", "--f-stop", "2.8"})));
}

TEST_F(RendererTest, FramesCameraAndLightsAsTheCommandDoes) {
  const std::string scene = write_scene("bare", {.camera = false, .light = false});
  Renderer renderer = load(folder_ / scene);
  std::vector<std::string> warnings;
  const RenderedImage rendered = render(
      renderer, small_image(), {.on_warning = [&](std::string_view message) { warnings.emplace_back(message); }});
  EXPECT_EQ(bits_of(rendered.film.resolve_rgba()), bits_of(command_rgba({scene, "--size", "48x32", "--spp", "8"})));
  ASSERT_EQ(warnings.size(), 2U);
  EXPECT_NE(warnings[0].find("no lights"), std::string::npos) << warnings[0];
  EXPECT_NE(warnings[1].find("no camera: one is fitted"), std::string::npos) << warnings[1];
  EXPECT_FALSE(renderer.bounds().isEmpty());
  EXPECT_TRUE(renderer.cameras().empty());
}

TEST_F(RendererTest, ChangesCameraAndSettingsWithoutRebuild) {
  Renderer renderer = load(folder_ / write_scene());
  static_cast<void>(render(renderer, small_image()));
  ImageSettings image = small_image();
  image.orbit = V3f(20.0f, 70.0f, 2.5f);
  image.size_px = V2i(40, 40);
  image.integrator.max_bounces = 2;
  bool built = false;
  const RenderedImage again = render(renderer, image, {.on_progress = [&](const ProgressSnapshot& snapshot) {
                                       built = built || snapshot.phase == Phase::build;
                                     }});
  EXPECT_FALSE(built);
  Renderer fresh = load(folder_ / "scene.gltf");
  EXPECT_EQ(bits_of(again.linear_rgb()), bits_of(render(fresh, image).linear_rgb()));
  EXPECT_EQ(bits_of(again.film.resolve_rgba()), bits_of(command_rgba({"scene.gltf", "--orbit", "20,70,2.5", "--size",
                                                                      "40x40", "--max-bounces", "2", "--spp", "8"})));
}

TEST_F(RendererTest, RebuildsOnlyForAnotherTime) {
  Renderer renderer = load(kScenes / "tiny" / "skin.gltf");
  ImageSettings image = small_image();
  int builds = 0;
  const auto render_at = [&](double time_s, float theta_deg) {
    image.time_s = time_s;
    image.orbit = V3f(theta_deg, 80.0f, 6.0f);
    bool built = false;
    const RenderedImage rendered = render(renderer, image, {.on_progress = [&](const ProgressSnapshot& snapshot) {
                                            built = built || snapshot.phase == Phase::build;
                                          }});
    builds += built ? 1 : 0;
    Renderer fresh = load(kScenes / "tiny" / "skin.gltf");
    EXPECT_EQ(bits_of(rendered.linear_rgb()), bits_of(render(fresh, image).linear_rgb())) << time_s;
  };
  render_at(0.0, 0.0f);
  render_at(0.0, 30.0f);
  EXPECT_EQ(builds, 1);
  render_at(0.5, 30.0f);
  EXPECT_EQ(builds, 2);
  render_at(0.0, 0.0f);
  EXPECT_EQ(builds, 3);
}

TEST_F(RendererTest, OwnCameraReplacesThoseOfTheScene) {
  Renderer renderer = load(folder_ / write_scene());
  ImageSettings image = small_image();
  image.orbit = V3f(20.0f, 70.0f, 2.5f);
  const RenderedImage orbit = render(renderer, image);
  image.orbit.reset();
  image.own_camera = orbit.camera;
  EXPECT_EQ(bits_of(render(renderer, image).linear_rgb()), bits_of(orbit.linear_rgb()));
}

TEST_F(RendererTest, FilmRefinesPassByPass) {
  Renderer renderer = load(folder_ / write_scene());
  const Result<DisplayTransform> view = DisplayTransform::create({});
  ASSERT_TRUE(view.ok());
  ImageSettings image = small_image();
  image.spp = 16;
  image.aovs = AovSet{};
  std::vector<uint64_t> samples;
  std::vector<uint8_t> display;
  const RenderedImage rendered = render(renderer, image, {.threads = 2, .on_pass = [&](const Film& film) {
                                                            samples.push_back(film.total_samples());
                                                            const std::vector<float> each = film.resolve(Aov::samples);
                                                            EXPECT_EQ(each, std::vector<float>(each.size(), each[0]));
                                                            display = display_rgba8(film, view.value());
                                                          }});
  ASSERT_GE(samples.size(), 3U);
  EXPECT_TRUE(std::is_sorted(samples.begin(), samples.end()));
  EXPECT_GE(samples.front(), 48U * 32U);
  EXPECT_EQ(samples.back(), 16U * 48U * 32U);
  EXPECT_EQ(display, display_rgba8(rendered.film, view.value()));
  image.spp = 16;
  EXPECT_EQ(bits_of(rendered.linear_rgb()), bits_of(render(renderer, image).linear_rgb()));
}

TEST_F(RendererTest, PassesShowTheCropOfAdaptiveRenders) {
  Renderer renderer = load(folder_ / write_scene());
  ImageSettings image = small_image();
  image.crop = PixelRect{V2i(3, 5), V2i(30, 21)};
  image.adaptive.noise_threshold = 0.2;
  image.spp = 64;
  int passes = 0;
  const RenderedImage rendered = render(renderer, image, {.on_pass = [&](const Film& film) {
                                          ++passes;
                                          EXPECT_EQ(film.crop(), *image.crop);
                                        }});
  EXPECT_GT(passes, 0);
  EXPECT_EQ(rendered.film.crop(), *image.crop);
  EXPECT_EQ(bits_of(rendered.linear_rgb()), bits_of(render(renderer, image).linear_rgb()));
}

TEST_F(RendererTest, DisplayPixelsAreThoseOfThePng) {
  Renderer renderer = load(folder_ / write_scene());
  const RenderedImage rendered = render(renderer, small_image());
  ASSERT_TRUE(rendered.write(folder_ / "a.png").ok());
  const Result<Image> png = read_image_file(folder_ / "a.png");
  ASSERT_TRUE(png.ok()) << png.error().message;
  const std::vector<uint8_t> display = display_rgba8(rendered.film, DisplayTransform::create({}).value());
  ASSERT_EQ(display.size(), 4U * 48U * 32U);
  const size_t channels = static_cast<size_t>(png.value().channels);
  for (size_t pixel = 0; pixel < 48U * 32U; ++pixel)
    for (size_t c = 0; c < std::min<size_t>(channels, 3); ++c)
      ASSERT_EQ(static_cast<uint8_t>(png.value().pixels[pixel * channels + c]), display[pixel * 4 + c]) << pixel;
}

TEST_F(RendererTest, CancelsFromCallbackAndFromAnotherThread) {
  Renderer renderer = load(folder_ / write_scene());
  ImageSettings image = small_image();
  image.spp = 1U << 20;
  CancelToken in_callback;
  const RenderedImage first =
      render(renderer, image, {.cancel = &in_callback, .on_pass = [&](const Film&) { in_callback.cancel_now(); }});
  EXPECT_TRUE(first.interrupted);
  EXPECT_GT(first.film.total_samples(), 0U);

  CancelToken in_thread;
  std::atomic<bool> started{false};
  std::jthread other([&] {
    while (!started) std::this_thread::yield();
    in_thread.cancel_now();
  });
  const RenderedImage second =
      render(renderer, image, {.cancel = &in_thread, .on_pass = [&](const Film&) { started = true; }});
  EXPECT_TRUE(second.interrupted);

  image.spp = 4;
  EXPECT_FALSE(render(renderer, image).interrupted);
}

TEST_F(RendererTest, ResumesCheckpointToTheSameBits) {
  Renderer renderer = load(folder_ / write_scene());
  ImageSettings image = small_image();
  image.spp = 24;
  const RenderedImage whole = render(renderer, image);
  RunOptions run;
  run.checkpoint.file = folder_ / "a.kacc";
  {
    CancelToken cancel;
    RunOptions cancelled = run;
    cancelled.cancel = &cancel;
    cancelled.on_pass = [&](const Film& film) {
      if (film.total_samples() > 4U * 48U * 32U) cancel.cancel_now();
    };
    EXPECT_TRUE(render(renderer, image, cancelled).interrupted);
  }
  Renderer another = load(folder_ / "scene.gltf");
  const RenderedImage resumed = render(another, image, run);
  EXPECT_FALSE(resumed.interrupted);
  EXPECT_EQ(bits_of(resumed.linear_rgb()), bits_of(whole.linear_rgb()));
  EXPECT_LT(resumed.statistics.rays.camera, 24U * 48U * 32U);
}

TEST_F(RendererTest, RefusesCheckpointOfAnotherRender) {
  Renderer renderer = load(folder_ / write_scene());
  const std::string file = (folder_ / "a.kacc").string();
  RunOptions run;
  run.checkpoint.file = file;
  static_cast<void>(render(renderer, small_image(), run));
  const auto refusal = [&](Renderer& by, const ImageSettings& image) {
    const Result<RenderedImage> refused = by.render(image, run);
    EXPECT_FALSE(refused.ok());
    if (refused.ok()) return std::string();
    EXPECT_EQ(refused.error().kind, ErrorKind::usage);
    return refused.error().message;
  };
  ImageSettings other = small_image();
  other.seed = 2;
  EXPECT_EQ(refusal(renderer, other), file +
                                          ": belongs to another render (--seed: 0 in the file, 2 here); use the same "
                                          "settings, or another file name");
  other = small_image();
  other.own_camera = fit_camera(renderer.bounds(), 1.5f);
  EXPECT_NE(refusal(renderer, other).find("--camera: 0 in the file, {\"camera_to_world\":["), std::string::npos)
      << refusal(renderer, other);
  other = small_image();
  other.spp = 4;
  other.planned_spp = 8;
  EXPECT_NE(refusal(renderer, other).find("--spp: 4 is below the 8 samples"), std::string::npos);
  write_scene("changed", {.grid = 2});
  Renderer changed = load(folder_ / "changed.gltf");
  EXPECT_NE(refusal(changed, small_image()).find("the scene has changed since the render was started"),
            std::string::npos);
  // The command line reads and merges it, and names the program that can resume it.
  EXPECT_EQ(run_program({"info", "a.kacc"}, folder_).exit_code, 0);
  const ProgramResult resumed = run_program({"resume", "a.kacc"}, folder_);
  EXPECT_EQ(resumed.exit_code, 2);
  EXPECT_NE(resumed.err.find("was written by a program that links Kindling"), std::string::npos) << resumed.err;
  EXPECT_EQ(run_program({"merge", "a.kacc", "-o", "merged.png"}, folder_).exit_code, 0);
  run.checkpoint.replace = true;
  other = small_image();
  other.seed = 2;
  EXPECT_TRUE(renderer.render(other, run).ok());
}

TEST_F(RendererTest, OutputsAreNoInputs) {
  Renderer first = load(folder_ / write_scene());
  ASSERT_TRUE(render(first, small_image()).write(folder_ / "env.exr").ok());
  std::filesystem::create_hard_link(folder_ / "scene.bin", folder_ / "buffer.png");
  std::filesystem::create_symlink("scene.bin", folder_ / "a.kacc");
  const std::string buffer = read_file("scene.bin"), env = read_file("env.exr");
  WorldSettings settings;
  settings.env_file = folder_ / "env.exr";
  Result<Renderer> loaded = Renderer::load(folder_ / "scene.gltf", settings);
  ASSERT_TRUE(loaded.ok()) << loaded.error().message;
  const RenderedImage image = render(loaded.value(), small_image());
  const auto refused = [](const Result<void>& written) { return written.ok() ? "" : written.error().message; };
  EXPECT_EQ(refused(image.write(folder_ / "env.exr")),
            (folder_ / "env.exr").string() +
                ": is a file that the image is rendered from; it would be overwritten: use another name");
  EXPECT_NE(refused(image.write(folder_ / "buffer.png")).find("by the name '"), std::string::npos);
  RunOptions run;
  run.checkpoint.file = folder_ / "a.kacc";
  const Result<RenderedImage> saved = loaded.value().render(small_image(), run);
  ASSERT_FALSE(saved.ok());
  EXPECT_EQ(saved.error().kind, ErrorKind::usage);
  EXPECT_NE(saved.error().message.find("is a file that the image is rendered from"), std::string::npos);
  EXPECT_TRUE(image.write(folder_ / "other.png").ok());
  EXPECT_EQ(read_file("scene.bin"), buffer);
  EXPECT_EQ(read_file("env.exr"), env);
}

TEST_F(RendererTest, RendersSceneFromMemory) {
  write_scene();
  Result<Scene> scene = load_gltf(folder_ / "scene.gltf", {}, nullptr);
  ASSERT_TRUE(scene.ok());
  scene.value().content_hash = 0;
  Result<Renderer> taken = Renderer::take(std::move(scene).value());
  ASSERT_TRUE(taken.ok()) << taken.error().message;
  Renderer from_file = load(folder_ / "scene.gltf");
  EXPECT_EQ(bits_of(render(taken.value(), small_image()).linear_rgb()),
            bits_of(render(from_file, small_image()).linear_rgb()));
  RunOptions run;
  run.checkpoint.file = folder_ / "b.kacc";
  const Result<RenderedImage> refused = taken.value().render(small_image(), run);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("Scene::content_hash"), std::string::npos) << refused.error().message;
}

TEST_F(RendererTest, ErrorsHaveTheMessagesOfTheCommand) {
  const std::string scene = write_scene();
  const auto same = [&](const Error& error, std::vector<std::string> flags) {
    flags.insert(flags.begin(), {"render", scene});
    const ProgramResult result = run_program(flags, folder_);
    EXPECT_NE(result.exit_code, 0);
    std::string message = error.message;
    const std::string prefix = folder_.string() + "/";
    for (size_t at = message.find(prefix); at != std::string::npos; at = message.find(prefix))
      message.erase(at, prefix.size());
    EXPECT_NE(result.err.find(message), std::string::npos) << message << "\n" << result.err;
  };
  WorldSettings world;
  world.env_file = folder_ / "missing.hdr";
  const Result<Renderer> no_environment = Renderer::load(folder_ / scene, world);
  ASSERT_FALSE(no_environment.ok());
  same(no_environment.error(), {"--env", "missing.hdr"});
  world = {};
  world.variant_name = "red";
  const Result<Renderer> no_variant = Renderer::load(folder_ / scene, world);
  ASSERT_FALSE(no_variant.ok());
  same(no_variant.error(), {"--variant", "red"});
  Renderer renderer = load(folder_ / scene);
  ImageSettings image = small_image();
  image.camera = "side";
  const Result<RenderedImage> no_camera = renderer.render(image);
  ASSERT_FALSE(no_camera.ok());
  same(no_camera.error(), {"--camera", "side"});
  image = small_image();
  image.crop = PixelRect{V2i(0, 0), V2i(100, 8)};
  const Result<RenderedImage> no_crop = renderer.render(image);
  ASSERT_FALSE(no_crop.ok());
  same(no_crop.error(), {"--size", "48x32", "--crop", "0,0,100,8"});
  EXPECT_TRUE(renderer.render(small_image()).ok()); // errors leave the renderer usable
  EXPECT_EQ(render(renderer, small_image()).write(folder_ / "a.gif").error().kind, ErrorKind::usage);
}

} // namespace
} // namespace kindling::test
