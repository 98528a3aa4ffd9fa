// Prints hashes of texture filters, mip levels and noise, for compare_compilers.py.
//
// It includes the sources themselves, so that it needs no library but Imath's headers.
// SPDX-License-Identifier: Apache-2.0
#define IMATH_HALF_NO_LOOKUP_TABLE // which is in Imath's library
#include "renderer/texture/mip_levels.cpp"
#include "renderer/texture/noise.cpp"
#include "renderer/texture/texture.cpp"
#include "renderer/texture/texture_lookup.cpp"
#include "tests/base/result_hash.h"

#include <array>
#include <cstring>
#include <memory>

namespace {

using namespace kindling;
using test::Inputs;
using test::ResultHash;

std::shared_ptr<const Image> image_of(Inputs& inputs, PixelType type, int channels) {
  auto image = std::make_shared<Image>();
  image->width = 13;
  image->height = 6;
  image->type = type;
  image->channels = channels;
  image->pixels.resize(image->byte_count());
  const size_t size = bytes_per_channel(type);
  for (size_t i = 0; i < image->pixels.size(); i += size) {
    const uint64_t bits = inputs.random.next_u64();
    const float value = inputs.any(-0.5f, 2.0f);
    const Imath::half half(value);
    if (type == PixelType::f32)
      std::memcpy(&image->pixels[i], &value, size);
    else if (type == PixelType::f16)
      std::memcpy(&image->pixels[i], &half, size);
    else
      std::memcpy(&image->pixels[i], &bits, size);
  }
  return image;
}

void add_samples(ResultHash& hash, Inputs& inputs, const Texture& texture, int count) {
  for (int i = 0; i < count; ++i) {
    const V2f uv = inputs.any_2d(-3.0f, 3.0f);
    const int level = i % texture.level_count;
    hash.add(texture.sample(uv, level));
    hash.add(texture.sample_rgb(uv, level));
    hash.add(texture.sample_channel(uv, i % 4, level));
    const float area = inputs.any(0.0f, 1.0f);
    if (!(area < 0.0f)) hash.add(texture.choose_level(area, inputs.number()));
  }
}

void print_textures(const char* name, bool special, int count) {
  Inputs inputs{test::Random(1), special};
  ResultHash hash;
  constexpr TextureWrap kWraps[] = {TextureWrap::repeat, TextureWrap::mirrored_repeat, TextureWrap::clamp_to_edge};
  for (const PixelType type : {PixelType::u8, PixelType::u16, PixelType::f16, PixelType::f32})
    for (int channels = 1; channels <= 4; ++channels)
      for (const TextureEncoding encoding : {TextureEncoding::linear, TextureEncoding::srgb})
        for (int k = 0; k < 3; ++k) {
          const auto image = image_of(inputs, type, channels);
          const TextureContent content = encoding == TextureEncoding::srgb ? TextureContent::color
                                         : k == 0                          ? TextureContent::data
                                                                           : TextureContent::tangent_normal;
          const auto levels = std::make_shared<MipLevels>(build_mip_levels(*image, content));
          TextureSettings settings{kWraps[k], kWraps[(k + channels) % 3], TextureFilter::linear, encoding};
          if (k == 2) settings.filter = TextureFilter::nearest;
          const Texture texture(image, settings, levels);
          add_samples(hash, inputs, texture, count / 96);
        }
  hash.print(name);
}

void print_noise(const char* name, bool special, int count) {
  Inputs inputs{test::Random(2), special};
  ResultHash hash;
  for (int i = 0; i < count / 4; ++i) {
    const V2f p = inputs.any_2d(-50.0f, 50.0f);
    const V3f q = inputs.any_3d(-50.0f, 50.0f);
    hash.add(noise::perlin(p));
    hash.add(noise::perlin_rgb(q));
    hash.add(noise::cell_rgb(p));
    hash.add(noise::cell(q));
    const float jitter = inputs.pick();
    V2f nearest_2d(0.0f);
    V3f nearest_3d(0.0f);
    hash.add(noise::worley(p, jitter, nearest_2d));
    hash.add(noise::worley(q, jitter, nearest_3d));
    hash.add(nearest_2d);
    hash.add(nearest_3d);
  }
  hash.print(name);
}

} // namespace

int main(int argc, char** argv) {
  const int count = test::input_count(argc, argv, 96000);
  test::print_usual_and_special("textures", count, print_textures);
  test::print_usual_and_special("noise", count, print_noise);
  return 0;
}
