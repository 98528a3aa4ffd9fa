// Renders files of freeze_scene by the kernels, and compares the images with the CPU's, to the bit.
//
// usage: render_frozen FILE...
//
// It needs the sources of the kernels (gpu_sources.txt) and no library, so that any compiler for
// any processor can make it.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/standard_arithmetic.h"
#include "renderer/device/kernels/all_kernels.h"
#include "renderer/integrator/stages/splat_pixels.h"
#include "tests/device/frozen/frozen_scene.h"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <utility>
#include <vector>

#include <sys/mman.h>

namespace kindling::test {
namespace {

// The arrays of a wave of one block: the whole image.
struct WaveArrays {
  explicit WaveArrays(const FrozenScene& frozen)
      : samples(static_cast<size_t>(frozen.width) * static_cast<size_t>(frozen.height) * frozen.samples),
        rays(samples.size()),
        sums(samples.size() / frozen.samples), block{.width = static_cast<uint32_t>(frozen.width),
                                                     .height = static_cast<uint32_t>(frozen.height),
                                                     .samples = frozen.samples} {}

  void lend_to(Wave& wave, const DeviceScene* scene) {
    wave.scene = scene;
    wave.blocks = std::span(&block, 1);
    wave.samples = samples.data();
    wave.rays = rays.data();
    wave.film.sums = sums;
    wave.block_rays = &block_rays;
    wave.losses = &losses;
  }
  [[nodiscard]] uint32_t sample_count() const { return static_cast<uint32_t>(samples.size()); }
  [[nodiscard]] uint32_t pixel_count() const { return static_cast<uint32_t>(sums.size()); }

  std::vector<CameraSample> samples;
  std::vector<WaveRays<uint32_t>> rays;
  std::vector<PixelSum> sums;
  WaveBlock block;
  WaveRays<uint64_t> block_rays;
  WaveLosses losses;
};

template <typename Argument>
void launch(void (*kernel)(const Argument&, uint32_t), const Argument& wave, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) kernel(wave, i);
}

// Returns the sums of the light of light paths, if there are any.
std::vector<SplatSum> render_paths(const DeviceScene* scene, const FrozenScene& frozen, WaveArrays& arrays) {
  PathWave wave;
  arrays.lend_to(wave, scene);
  const size_t count = arrays.sample_count();
  std::vector<PathState> states(count);
  std::vector<MediumStack> media(count);
  std::vector<accel::Ray> path_rays(count), shadow_rays(count);
  std::vector<accel::Hit> hits(count);
  std::vector<uint32_t> active(count), next(count);
  std::vector<WaveShadow> shadow_records(count);
  uint32_t next_count = 0, shadow_count = 0;
  wave.states = states.data();
  wave.media = media.data();
  wave.path_rays = path_rays.data();
  wave.hits = hits.data();
  wave.active.paths = active.data();
  wave.next = {&next_count, next.data()};
  wave.shadows.count = &shadow_count;
  wave.shadow_rays = shadow_rays.data();
  wave.shadow_records = shadow_records.data();
  launch(kernels::begin_path, wave, arrays.sample_count());
  for (uint32_t paths = arrays.sample_count(); paths > 0; paths = next_count) {
    launch(kernels::intersect, wave, paths);
    next_count = shadow_count = 0;
    launch(frozen.passes > 0 ? kernels::shade_beside_light_paths : kernels::shade, wave, paths);
    launch(kernels::trace_shadow, wave, shadow_count);
    std::swap(wave.active.paths, wave.next.paths);
  }
  launch(kernels::finish_pixel, wave, arrays.pixel_count());
  if (frozen.passes == 0) return {};
  const uint32_t light_path_count = frozen.passes * arrays.pixel_count();
  std::vector<WaveLightPath> light_paths(light_path_count);
  std::vector<WaveSplat> splats(light_path_count);
  std::vector<SplatSum> sums(arrays.pixel_count());
  wave.light_paths = light_paths.data();
  wave.splats = splats.data();
  next_count = 0;
  launch(kernels::begin_light_path, wave, light_path_count);
  while (next_count > 0) {
    const uint32_t paths = next_count;
    std::swap(wave.active.paths, wave.next.paths);
    launch(kernels::intersect, wave, paths);
    next_count = shadow_count = 0;
    launch(kernels::scatter_light_path, wave, paths);
    launch(kernels::trace_sight, wave, shadow_count);
    for (uint32_t i = 0; i < shadow_count; ++i)
      visit_splat_pixels(scene->filter, splats[i].film_px, V2i(0), V2i(frozen.width, frozen.height),
                         [&](const V2i& pixel, float weight) {
                           SplatSum& sum = sums[static_cast<size_t>(pixel.y * frozen.width + pixel.x)];
                           const Rgb light = splats[i].radiance * weight;
                           for (int c = 0; c < 3; ++c) sum.rgb[c].add(static_cast<double>(light[c]));
                         });
  }
  return sums;
}

void render_trees(const DeviceScene* scene, WaveArrays& arrays) {
  constexpr uint32_t kRound = 1024, kMaxChildren = 64;
  TreeWave wave;
  arrays.lend_to(wave, scene);
  std::vector<WhittedSample> sums(arrays.sample_count());
  std::vector<WhittedNode> waiting(2 * size_t{arrays.sample_count()} + size_t{kRound} * kMaxChildren), nodes(kRound);
  uint32_t count = arrays.sample_count();
  wave.sums = sums.data();
  wave.waiting = waiting.data();
  wave.waiting_count = &count;
  wave.nodes = nodes.data();
  launch(kernels::begin_tree, wave, count);
  while (count > 0) {
    const uint32_t round = std::min(count, kRound);
    wave.first_taken = count - round;
    launch(kernels::take_node, wave, round);
    count = wave.first_taken;
    if (waiting.size() - count < size_t{round} * kMaxChildren) std::abort();
    launch(kernels::trace_node, wave, round);
  }
  launch(kernels::finish_tree_pixel, wave, arrays.pixel_count());
}

// Returns the hash of the image, and sets that of the CPU's.
uint64_t render_file(const char* name, uint64_t& expected) {
  std::ifstream file(name, std::ios::binary);
  FrozenScene frozen;
  file.read(reinterpret_cast<char*>(&frozen), sizeof frozen);
  if (!file || frozen.magic != FrozenScene::kMagic || frozen.scene_bytes != sizeof(DeviceScene)) std::abort();
  void* const block = mmap(reinterpret_cast<void*>(frozen.address), frozen.bytes, PROT_READ | PROT_WRITE,
                           MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED_NOREPLACE, -1, 0);
  if (block != reinterpret_cast<void*>(frozen.address)) std::abort();
  file.read(static_cast<char*>(block), static_cast<std::streamsize>(frozen.bytes));
  if (!file) std::abort();
  WaveArrays arrays(frozen);
  const auto* scene = static_cast<const DeviceScene*>(block);
  std::vector<SplatSum> splats;
  if (frozen.whitted != 0)
    render_trees(scene, arrays);
  else
    splats = render_paths(scene, frozen, arrays);
  munmap(block, frozen.bytes);
  expected = frozen.rendered;
  static_assert(sizeof(PixelSum) % sizeof(uint64_t) == 0);
  return hash_of_splats(hash_of_sums({reinterpret_cast<const uint64_t*>(arrays.sums.data()),
                                      arrays.sums.size() * sizeof(PixelSum) / sizeof(uint64_t)}),
                        splats);
}

} // namespace
} // namespace kindling::test

int main(int argc, char** argv) {
  const kindling::StandardArithmetic standard_arithmetic;
  int different = 0;
  for (int i = 1; i < argc; ++i) {
    uint64_t expected = 0;
    const uint64_t found = kindling::test::render_file(argv[i], expected);
    if (found == expected) continue;
    std::printf("%s: other bits\n", argv[i]);
    ++different;
  }
  std::printf("%d images, %d different\n", argc - 1, different);
  return different == 0 && argc > 1 ? 0 : 1;
}
