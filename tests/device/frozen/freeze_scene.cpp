// Writes a scene as a device would hold it, with a hash of a small image by the CPU.
//
// usage: freeze_scene SCENE FILE path|light_paths|whitted
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/device.h"
#include "renderer/device/scene_on_device.h"
#include "renderer/facade/render_stage.h"
#include "renderer/integrator/light_paths/light_paths.h"
#include "renderer/integrator/path_integrator.h"
#include "renderer/light/per_light_sampling.h"
#include "renderer/session/prepare/train_guide.h"
#include "renderer/session/render_session.h"
#include "tests/device/frozen/frozen_scene.h"

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string_view>

#include <sys/mman.h>

namespace {

using namespace kindling;

constexpr uintptr_t kAddress = uintptr_t{1} << 36; // free in all processes, arm64 ones too

[[noreturn]] void fail(const std::string& message) {
  std::fprintf(stderr, "freeze_scene: %s\n", message.c_str());
  std::exit(1);
}

template <typename T>
T valid(Result<T> result) {
  if (!result.ok()) fail(result.error().message);
  return std::move(result).value();
}

// A device with one block of memory, at an address that other processes have free as well.
class BlockDevice final : public Device {
 public:
  [[nodiscard]] std::string name() const override { return "block"; }
  [[nodiscard]] std::byte* allocate(size_t bytes) override {
    void* const block = mmap(reinterpret_cast<void*>(kAddress), bytes, PROT_READ | PROT_WRITE,
                             MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0);
    if (block == MAP_FAILED) fail("the address of the block is taken");
    return static_cast<std::byte*>(block);
  }
  void release(std::byte* /*memory*/) noexcept override {}
  void upload(std::span<const std::byte> from, std::byte* to) override {
    if (!from.empty()) std::memcpy(to, from.data(), from.size());
  }
  void download(const std::byte* /*from*/, std::span<std::byte> /*to*/) override {}
  void clear(std::byte* /*memory*/, size_t /*bytes*/) override {}
  void launch(Kernel /*kernel*/, std::span<const std::byte> /*argument*/, uint32_t /*count*/) override {}
  [[nodiscard]] uint32_t wave_size() const override { return 0; }
};

class Silence final : public ProgressListener {
  void on_progress(const ProgressSnapshot& /*snapshot*/) override {}
  void on_warning(std::string_view /*message*/) override {}
  void on_info(std::string_view /*message*/) override {}
};

// Returns the sums of a plane of the film; none: it is absent.
template <typename Sum>
std::vector<Sum> sums_of(const Film& film, std::string_view name) {
  std::vector<Sum> sums;
  for (const Film::ConstPlane& plane : film.planes())
    if (plane.name == name) {
      sums.resize(plane.bytes.size() / sizeof(Sum));
      std::memcpy(sums.data(), plane.bytes.data(), plane.bytes.size());
    }
  return sums;
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 4) fail("usage: freeze_scene SCENE FILE path|light_paths|whitted");
  const bool whitted = std::string_view(argv[3]) == "whitted";
  Silence silence;
  ImageSettings image;
  image.size_px = V2i(48, 32);
  const std::unique_ptr<RenderScene> scene = valid(load_render_scene(argv[1], {}, &silence));
  PosedImage posed = valid(pose_image(*scene, image));
  const RenderStage stage = valid(build_stage(*scene, std::move(posed), image, false, nullptr, silence));
  const World& world = *stage.world;
  const Camera& camera = *stage.camera;

  RenderSettings settings;
  settings.size_px = stage.size_px;
  settings.samples_per_pixel = 4;
  settings.guiding = Guiding::on;
  settings.integrator.kind = whitted ? IntegratorKind::whitted : IntegratorKind::path;
  if (std::string_view(argv[3]) == "light_paths") settings.integrator.light_paths = 0.5f;
  const TrainedGuide trained = train_guide(world, camera, settings, nullptr, {});
  const Sampler sampler(settings.seed, settings.sampler, settings.planned());
  const PerLightSampling lights(world.light_set());
  PathStages stages = make_path_stages(settings.integrator, world, camera, sampler, trained.guide.get());
  const std::unique_ptr<LightPaths> light_paths =
      make_light_paths(settings.integrator, world, camera, settings.filter, sampler.seed());
  stages.light_paths = light_paths.get();
  const std::unique_ptr<const PresampledEnvironment> presampled =
      presample_environment(settings.integrator, world.lights, sampler.seed());
  stages.presampled = presampled.get();
  const WhittedShader shader = make_whitted_shader(settings.integrator, world, camera, sampler, lights);
  const FirstHitStages first_hit = make_first_hit_stages(settings.integrator, world, camera, sampler);
  BlockDevice device;
  const SceneOnDevice frozen(device,
                             {world, camera, stages, shader, first_hit, sampler, settings.filter, light_paths.get()});
  const Film film = valid(render(world, camera, settings, nullptr, nullptr)).film;

  test::FrozenScene header;
  header.address = kAddress;
  header.bytes = frozen.bytes();
  header.width = settings.size_px.x;
  header.height = settings.size_px.y;
  header.samples = settings.samples_per_pixel;
  header.whitted = whitted ? 1 : 0;
  header.rendered = test::hash_of_splats(test::hash_of_sums(sums_of<uint64_t>(film, "beauty")),
                                         light_paths ? sums_of<SplatSum>(film, "splats") : std::vector<SplatSum>{});
  if (light_paths) header.passes = light_path_passes(settings.integrator.light_paths, {0, header.samples}).count();
  std::ofstream file(argv[2], std::ios::binary);
  file.write(reinterpret_cast<const char*>(&header), sizeof header);
  file.write(reinterpret_cast<const char*>(frozen.address()), static_cast<std::streamsize>(frozen.bytes()));
  if (!file.flush()) fail("the file cannot be written");
}
