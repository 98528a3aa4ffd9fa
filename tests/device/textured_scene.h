// A small scene whose textures have many tiles.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/hash.h"
#include "tests/integrator/motion_scenes.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

namespace kindling::test {

// Noise in all bits; alpha is between 0 and 1.
inline std::shared_ptr<const Image> noisy_image(int width, int height, int channels, PixelType type = PixelType::u8) {
  auto image = std::make_shared<Image>(Image{width, height, channels, type, {}});
  image->pixels.resize(image->byte_count());
  for (size_t i = 0; i < image->pixels.size(); ++i)
    image->pixels[i] =
        static_cast<std::byte>(hash_u32(static_cast<uint32_t>(i) + static_cast<uint32_t>(width * channels)) & 0xffU);
  return image;
}

// Gives a quad the normals and tangents that normal maps and anisotropy need.
inline Primitive with_tangents(Primitive quad, const V3f& normal, const V3f& tangent) {
  for (size_t i = 0; i < quad.positions.size(); ++i) {
    quad.normals.push_back(normal);
    quad.tangents.emplace_back(tangent.x, tangent.y, tangent.z, 1.0f);
  }
  return quad;
}

// A coated floor, a wall, a textured lamp, a cut-out, a veil and a thin wall, each with textures of
// its own.
inline Scene textured_scene() {
  Scene scene;
  scene.source = "test";
  scene.scenes.emplace_back();
  const auto texture = [&](std::shared_ptr<const Image> image, TextureWrap wrap = TextureWrap::repeat,
                           TextureFilter filter = TextureFilter::linear) {
    scene.textures.push_back({.image = std::move(image), .wrap_u = wrap, .wrap_v = wrap, .filter = filter});
    TextureSlot slot;
    slot.texture = static_cast<int>(scene.textures.size()) - 1;
    return slot;
  };
  const auto repeated = [](TextureSlot slot, float times) {
    slot.scale = V2f(times);
    return slot;
  };

  Material floor; // twelve textures at once
  floor.base_color_texture = texture(noisy_image(600, 400, 3));
  floor.metallic_roughness_texture = texture(noisy_image(512, 512, 3), TextureWrap::mirrored_repeat);
  floor.normal_texture = texture(noisy_image(400, 600, 3));
  floor.specular_texture = repeated(texture(noisy_image(260, 260, 4)), 3.0f);
  floor.specular_color_texture = floor.specular_texture;
  floor.clearcoat_factor = floor.anisotropy_strength = floor.iridescence_factor = 1.0f;
  floor.clearcoat_texture = texture(noisy_image(400, 400, 1));
  floor.clearcoat_roughness_texture = texture(noisy_image(300, 300, 2));
  floor.clearcoat_normal_texture = texture(noisy_image(256, 256, 3, PixelType::u16));
  floor.sheen_color_factor = Rgb(0.5f);
  floor.sheen_color_texture = texture(noisy_image(200, 666, 3));
  floor.sheen_roughness_texture = texture(noisy_image(180, 180, 4, PixelType::u16));
  floor.anisotropy_texture = texture(noisy_image(354, 354, 3), TextureWrap::clamp_to_edge);
  floor.iridescence_texture = texture(noisy_image(280, 280, 1, PixelType::u16));
  add_object(scene, floor,
             with_tangents(quad(V3f(-5, -1, 5), V3f(10, 0, 0), V3f(0, 0, -10), 0), V3f(0, 1, 0), V3f(1, 0, 0)));

  Material wall; // seen from near, without filtering, beyond all its texels
  wall.metallic_factor = 0.0f;
  wall.base_color_texture = texture(noisy_image(514, 1022, 1), TextureWrap::repeat, TextureFilter::nearest);
  wall.base_color_texture.offset = V2f(0.3f, -2.7f);
  add_object(scene, wall, quad(V3f(-5, -1, -3), V3f(10, 0, 0), V3f(0, 6, 0), 0));

  Material lamp = emissive_material(Rgb(9.0f, 8.0f, 7.0f));
  lamp.emissive_texture = texture(noisy_image(440, 440, 3));
  add_object(scene, lamp, quad(V3f(-1, 3, -1), V3f(2, 0, 0), V3f(0, 0, 2), 0));

  Material cut_out = diffuse_material(Rgb(0.8f));
  cut_out.alpha_mode = AlphaMode::mask;
  cut_out.base_color_texture = texture(noisy_image(320, 320, 4));
  add_object(scene, cut_out, quad(V3f(-2, -1, 0.5f), V3f(1.5f, 0, 0), V3f(0, 2, 0), 0));
  Material veil = diffuse_material(Rgb(0.8f));
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color_texture = texture(noisy_image(380, 380, 4));
  add_object(scene, veil, quad(V3f(0.5f, -1, 0.5f), V3f(1.5f, 0, 0), V3f(0, 2, 0), 0));

  Material thin_wall;
  thin_wall.metallic_factor = 0.0f;
  thin_wall.roughness_factor = 0.05f;
  thin_wall.transmission_factor = 1.0f;
  thin_wall.base_color_texture = texture(noisy_image(420, 220, 3));
  thin_wall.metallic_roughness_texture = texture(noisy_image(220, 420, 3));
  thin_wall.transmission_texture = texture(noisy_image(240, 240, 1));
  add_object(scene, thin_wall, quad(V3f(-3, -0.9f, 2.0f), V3f(6, 0, 0), V3f(0, 1.5f, 0), 0));

  Material sign = diffuse_material(Rgb(0.0f));
  sign.unlit = true;
  sign.base_color_texture = texture(noisy_image(512, 256, 4, PixelType::u16));
  add_object(scene, sign, quad(V3f(-0.4f, 0, -1), V3f(0.8f, 0, 0), V3f(0, 0.8f, 0), 0));
  return scene;
}

inline std::unique_ptr<const World> textured_world() {
  return make_world(textured_scene(), accel::Kind::kdtree, std::make_shared<Environment>(Rgb(0.4f, 0.5f, 0.6f)));
}

} // namespace kindling::test
