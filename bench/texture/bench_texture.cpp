// Benchmarks of texture look-ups: each layout at random coordinates, in small and large images.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/texture/texture.h"

#include <benchmark/benchmark.h>

#include <memory>
#include <random>
#include <vector>

namespace kindling {
namespace {

std::shared_ptr<const Image> make_image(int size, int channels, PixelType type) {
  auto image = std::make_shared<Image>(Image{size, size, channels, type, {}});
  image->pixels.resize(image->byte_count());
  std::mt19937 random(1);
  // As floats these bytes are arbitrary finite numbers.
  for (std::byte& byte : image->pixels) byte = static_cast<std::byte>(random() & 0x3f);
  return image;
}

std::vector<V2f> random_coordinates() {
  std::mt19937 random(2);
  std::uniform_real_distribution<float> unit(-1.0f, 2.0f);
  std::vector<V2f> uv(1 << 14);
  for (V2f& p : uv) p = {unit(random), unit(random)};
  return uv;
}

enum class Call { all, rgb, channel };

// Arguments: side in texels, channels, PixelType, sRGB, wrap.
template <Call kCall>
void look_up(benchmark::State& state) {
  const auto image = make_image(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)),
                                static_cast<PixelType>(state.range(2)));
  const auto wrap = static_cast<TextureWrap>(state.range(4));
  const Texture texture(image, {wrap, wrap, TextureFilter::linear,
                                state.range(3) != 0 ? TextureEncoding::srgb : TextureEncoding::linear});
  const std::vector<V2f> uv = random_coordinates();
  size_t i = 0;
  for (auto _ : state) {
    const V2f& p = uv[i++ & (uv.size() - 1)];
    if constexpr (kCall == Call::all) benchmark::DoNotOptimize(texture.sample(p));
    if constexpr (kCall == Call::rgb) benchmark::DoNotOptimize(texture.sample_rgb(p));
    if constexpr (kCall == Call::channel) benchmark::DoNotOptimize(texture.sample_channel(p, 0));
  }
  state.SetItemsProcessed(static_cast<int64_t>(state.iterations()));
}

void layouts(benchmark::internal::Benchmark* bench) {
  bench->ArgNames({"size", "channels", "type", "srgb", "wrap"});
  for (const int size : {64, 2048}) {
    for (const int channels : {1, 3, 4}) {
      for (const int srgb : {0, 1}) bench->Args({size, channels, static_cast<int>(PixelType::u8), srgb, 0});
    }
    bench->Args({size, 3, static_cast<int>(PixelType::u8), 1, 1});
    bench->Args({size, 3, static_cast<int>(PixelType::u16), 1, 0});
    bench->Args({size, 3, static_cast<int>(PixelType::f16), 0, 0});
    bench->Args({size, 3, static_cast<int>(PixelType::f32), 0, 0});
  }
}

BENCHMARK(look_up<Call::all>)->Name("texture/sample")->Apply(layouts);
BENCHMARK(look_up<Call::rgb>)->Name("texture/sample_rgb")->Apply(layouts);
BENCHMARK(look_up<Call::channel>)->Name("texture/sample_channel")->Apply(layouts);

} // namespace
} // namespace kindling

BENCHMARK_MAIN();
