// A scene with block-compressed textures is the image of the same scene with PNG files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "renderer/image/write_image.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"
#include "tests/image/ktx2_files.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

namespace kindling::test {
namespace {

using Json = nlohmann::json;
using Bytes = std::vector<uint8_t>;

constexpr int kSide = 16; // of a texture, in texels
constexpr int kBlocks = kSide / 4;

// RGBA of 8 bits, or fractions of more.
using Color = std::array<double, 4>;

// Two colors of a block, of its left and its right half, or one.
struct Block {
  Bytes bytes;
  Color left{}, right{};
};

// The colors that block (x, y) should have about: they differ between all blocks.
std::array<int, 4> wanted(int x, int y, int half) {
  const int at = kBlocks * y + x;
  return {(37 * at + 90 * half + 20) % 256, (91 * at + 40) % 256, (151 * at + 120 * half + 60) % 256,
          (53 * at + 100 * half) % 156 + 100};
}
// Directions of a normal map, as unsigned numbers.
std::array<int, 4> wanted_direction(int x, int y, int half) {
  return {128 + 22 * (x - 2) + 9 * half, 128 + 25 * (y - 1) - 13 * half, 0, 255};
}

Color of_bytes(int r, int g, int b, int a = 255) { return {r / 255.0, g / 255.0, b / 255.0, a / 255.0}; }

// Columns 0 and 1 are the left half; bit or field i of an index word is texel (i % 4, i / 4).
bool is_right(int texel) { return texel % 4 >= 2; }

// BC1 (S3TC, Khronos Data Format 1.3, section 18): two colors of 5, 6 and 5 bits.
Block bc1(const std::array<int, 4>& a, const std::array<int, 4>& b) {
  Block block;
  const auto pack = [](const std::array<int, 4>& c) { return (c[0] >> 3) << 11 | (c[1] >> 2) << 5 | c[2] >> 3; };
  const auto color = [](const std::array<int, 4>& c) {
    const auto widened = [](int value, double largest) { return static_cast<int>(std::lround(value * 255 / largest)); };
    return of_bytes(widened(c[0] >> 3, 31), widened(c[1] >> 2, 63), widened(c[2] >> 3, 31));
  };
  uint32_t indices = 0;
  for (int i = 0; i < 16; ++i) indices |= (is_right(i) ? 1U : 0U) << (2 * i);
  for (const int c : {pack(a), pack(b)})
    for (const int shift : {0, 8}) block.bytes.push_back(static_cast<uint8_t>(c >> shift));
  for (int i = 0; i < 4; ++i) block.bytes.push_back(static_cast<uint8_t>(indices >> (8 * i)));
  block.left = color(a);
  block.right = color(b);
  return block;
}

// BC4's block: two numbers of 8 bits, and 16 indices of 3 bits, 0 and 1.
Bytes bc4(int left, int right) {
  Bytes bytes = {static_cast<uint8_t>(left), static_cast<uint8_t>(right)};
  uint64_t indices = 0;
  for (int i = 0; i < 16; ++i) indices |= (is_right(i) ? uint64_t{1} : 0) << (3 * i);
  for (int i = 0; i < 6; ++i) bytes.push_back(static_cast<uint8_t>(indices >> (8 * i)));
  return bytes;
}

Block bc3(const std::array<int, 4>& a, const std::array<int, 4>& b) {
  Block block = bc1(a, b);
  const Bytes alpha = bc4(a[3], b[3]);
  block.bytes.insert(block.bytes.begin(), alpha.begin(), alpha.end());
  block.left[3] = a[3] / 255.0;
  block.right[3] = b[3] / 255.0;
  return block;
}

Block bc5(const std::array<int, 4>& a, const std::array<int, 4>& b) {
  Block block{bc4(a[0], b[0]), of_bytes(a[0], a[1], 0), of_bytes(b[0], b[1], 0)};
  const Bytes green = bc4(a[1], b[1]);
  block.bytes.insert(block.bytes.end(), green.begin(), green.end());
  return block;
}

// BC7, mode 5: endpoints of 7 bits for colors and 8 for alpha, each with indices of 2 bits.
Block bc7(const std::array<int, 4>& a, const std::array<int, 4>& b) {
  Block block{Bytes(16), {}, {}};
  size_t at = 0;
  const auto put = [&](int value, size_t bits) {
    for (size_t i = 0; i < bits; ++i, ++at)
      block.bytes[at / 8] = static_cast<uint8_t>(block.bytes[at / 8] | (value >> i & 1) << (at % 8));
  };
  put(1 << 5, 6);
  put(0, 2); // no rotation of channels
  for (size_t c = 0; c < 3; ++c)
    for (const auto& color : {a, b}) put(color[c] >> 1, 7);
  for (const auto& color : {a, b}) put(color[3], 8);
  for (int set = 0; set < 2; ++set)
    for (int i = 0; i < 16; ++i) put(is_right(i) ? 3 : 0, i == 0 ? 1 : 2); // the first index lacks its upper bit
  const auto widened = [](const std::array<int, 4>& c) {
    const auto full = [](int v) { return (v >> 1) << 1 | v >> 7; };
    return of_bytes(full(c[0]), full(c[1]), full(c[2]), c[3]);
  };
  block.left = widened(a);
  block.right = widened(b);
  return block;
}

// ETC2, individual mode: colors of 4 bits for the left and the right half, 2 added by table 0.
Block etc2(const std::array<int, 4>& a, const std::array<int, 4>& b) {
  Block block;
  for (size_t c = 0; c < 3; ++c) block.bytes.push_back(static_cast<uint8_t>((a[c] >> 4) << 4 | b[c] >> 4));
  block.bytes.insert(block.bytes.end(), {0, 0, 0, 0, 0});
  const auto color = [](const std::array<int, 4>& c) {
    const auto full = [](int v) { return std::min(255, (v >> 4) * 17 + 2); };
    return of_bytes(full(c[0]), full(c[1]), full(c[2]));
  };
  block.left = color(a);
  block.right = color(b);
  return block;
}

// EAC: a base of 8 bits, a factor of 1 and table 0, whose entries 4 and 7 add 2 and 14. Indices go
// down the columns, from the highest bits on.
Bytes eac(int base) {
  uint64_t indices = 0;
  for (int i = 0; i < 16; ++i) indices = indices << 3 | (i < 8 ? 4U : 7U);
  Bytes bytes = {static_cast<uint8_t>(base), 1 << 4};
  for (int i = 5; i >= 0; --i) bytes.push_back(static_cast<uint8_t>(indices >> (8 * i)));
  return bytes;
}

Block etc2_rgba(const std::array<int, 4>& a, const std::array<int, 4>& b) {
  Block block = etc2(a, b);
  const int base = a[3] - 14;
  const Bytes alpha = eac(base);
  block.bytes.insert(block.bytes.begin(), alpha.begin(), alpha.end());
  block.left[3] = (base + 2) / 255.0;
  block.right[3] = (base + 14) / 255.0;
  return block;
}

// Two channels of 11 bits: 8 base + 4 + 8 times what the table adds.
Block eac_rg11(const std::array<int, 4>& a, const std::array<int, 4>&) {
  Block block{eac(a[0]), {}, {}};
  const Bytes green = eac(a[1]);
  block.bytes.insert(block.bytes.end(), green.begin(), green.end());
  const auto fraction = [](int base, int added) { return (8 * base + 4 + 8 * added) / 2047.0; };
  block.left = {fraction(a[0], 2), fraction(a[1], 2), 0.0, 1.0};
  block.right = {fraction(a[0], 14), fraction(a[1], 14), 0.0, 1.0};
  return block;
}

// ASTC's block of one color, of 16 bits each.
Block astc(const std::array<int, 4>& a, const std::array<int, 4>&) {
  Block block{{0xfc, 0xfd, 0xff, 0xff, 0xff, 0xff, 0xff, 0xff}, of_bytes(a[0], a[1], a[2], a[3]), {}};
  for (const int c : a) block.bytes.insert(block.bytes.end(), 2, static_cast<uint8_t>(c));
  block.right = block.left;
  return block;
}
// A direction (x, y, z): x is stored in gray, y in alpha.
Block astc_direction(const std::array<int, 4>& a, const std::array<int, 4>& b) {
  Block block = astc({a[0], a[0], a[0], a[1]}, b);
  block.left = block.right = of_bytes(a[0], a[1], 0);
  return block;
}

struct Format {
  const char* name;
  uint32_t vk_format;
  Block (*encode)(const std::array<int, 4>&, const std::array<int, 4>&);
  bool normals = false, alpha = false;
  const char* swizzle = "";
};
constexpr Format kFormats[] = {{"bc1", 132, bc1},
                               {"bc3", 138, bc3, false, true},
                               {"bc7", 146, bc7, false, true},
                               {"etc2", 148, etc2},
                               {"etc2_rgba", 152, etc2_rgba, false, true},
                               {"astc", kFirstAstc + 1, astc, false, true},
                               {"bc5", 141, bc5, true},
                               {"eac_rg11", 155, eac_rg11, true},
                               {"astc_ra", kFirstAstc, astc_direction, true, false, "ra01"},
                               {"astc_gray_alpha", kFirstAstc, astc_direction, true}};

class BlockTextures : public SceneFolder {
 protected:
  // Writes NAME.ktx2, and NAME.png with the same texels.
  void write_texture(const Format& format) const {
    Ktx2File ktx2{format.vk_format, kSide, kSide, {}, format.swizzle};
    std::vector<float> texels(size_t{4} * kSide * kSide);
    for (int y = 0; y < kBlocks; ++y)
      for (int x = 0; x < kBlocks; ++x) {
        const auto pick = format.normals ? wanted_direction : wanted;
        const Block block = format.encode(pick(x, y, 0), pick(x, y, 1));
        ktx2.level.insert(ktx2.level.end(), block.bytes.begin(), block.bytes.end());
        for (int i = 0; i < 16; ++i) {
          Color color = is_right(i) ? block.right : block.left;
          const double u = 2 * color[0] - 1, v = 2 * color[1] - 1;
          if (format.normals) color[2] = 0.5 + 0.5 * std::sqrt(1 - u * u - v * v);
          const int at = (4 * y + i / 4) * kSide + 4 * x + i % 4;
          for (int c = 0; c < 4; ++c)
            texels[static_cast<size_t>(4 * at + c)] = static_cast<float>(color[static_cast<size_t>(c)]);
        }
      }
    const FileBytes file = write_ktx2(ktx2);
    write_file(std::string(format.name) + ".ktx2", {reinterpret_cast<const char*>(file.data()), file.size()});
    ASSERT_TRUE(write_png(folder_ / (std::string(format.name) + ".png"), texels, V2i(kSide),
                          format.normals && format.vk_format != kFirstAstc ? 16 : 8)
                    .ok());
  }

  // A row of squares, one for each format, in front of a camera.
  void write_gltf(const std::string& extension) const {
    const std::vector<float> numbers = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, // positions
                                        0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, // normals
                                        0, 1, 1, 1, 1, 0, 0, 0};            // texture coordinates
    std::string bytes(reinterpret_cast<const char*>(numbers.data()), numbers.size() * 4);
    for (const uint16_t index : {0, 1, 2, 0, 2, 3}) bytes.append(reinterpret_cast<const char*>(&index), 2);
    write_file("quad.bin", bytes);
    Json gltf = Json::parse(R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": []}],
      "buffers": [{"uri": "quad.bin", "byteLength": 140}],
      "bufferViews": [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 48},
        {"buffer": 0, "byteOffset": 96, "byteLength": 32}, {"buffer": 0, "byteOffset": 128, "byteLength": 12}],
      "accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3", "min": [0,0,0], "max": [1,1,0]},
        {"bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC3"},
        {"bufferView": 2, "componentType": 5126, "count": 4, "type": "VEC2"},
        {"bufferView": 3, "componentType": 5123, "count": 6, "type": "SCALAR"}],
      "samplers": [{"magFilter": 9728}],
      "cameras": [{"type": "orthographic", "orthographic": {"xmag": 2.75, "ymag": 1.1, "znear": 0.1, "zfar": 100}}],
      "nodes": [{"camera": 0, "translation": [2.7, 1.05, 5]}],
      "extensionsUsed": ["KHR_texture_basisu"]})");
    gltf["scenes"][0]["nodes"].push_back(0);
    int number = 0;
    for (const Format& format : kFormats) {
      gltf["images"].push_back({{"uri", format.name + extension}});
      const Json source = {{"source", number}};
      Json texture = {{"sampler", 0}};
      if (extension == ".ktx2")
        texture["extensions"]["KHR_texture_basisu"] = source;
      else
        texture.update(source);
      gltf["textures"].push_back(texture);
      const Json slot = {{"index", number}};
      Json material = {{"pbrMetallicRoughness", {{"metallicFactor", 0.0}, {"roughnessFactor", 0.4}}}};
      if (format.normals)
        material["normalTexture"] = slot;
      else
        material["pbrMetallicRoughness"]["baseColorTexture"] = slot;
      if (format.alpha) material["alphaMode"] = "BLEND";
      gltf["materials"].push_back(material);
      gltf["meshes"].push_back({{"primitives",
                                 {{{"attributes", {{"POSITION", 0}, {"NORMAL", 1}, {"TEXCOORD_0", 2}}},
                                   {"indices", 3},
                                   {"material", number}}}}});
      gltf["scenes"][0]["nodes"].push_back(gltf["nodes"].size());
      gltf["nodes"].push_back({{"mesh", number}, {"translation", {1.1 * (number % 5), 1.1 * (number / 5), 0}}});
      ++number;
    }
    write_file("scene" + extension + ".gltf", gltf.dump());
  }

  [[nodiscard]] std::vector<float> render(const std::string& extension) const {
    const ProgramResult result = run_program({"render", "scene" + extension + ".gltf", "--size", "110x44", "--spp",
                                              "16", "--exr-float", "-o", "out.exr", "--background", "0.2,0.2,0.2"},
                                             folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    for (const std::string& line : result.err_lines())
      EXPECT_EQ(line.find("warning: scene" + extension + ".gltf: /"), std::string::npos) << line;
    const Result<Image> image = read_image_file(folder_ / "out.exr");
    EXPECT_TRUE(image.ok());
    std::vector<float> values(image.value().pixels.size() / sizeof(float));
    std::memcpy(values.data(), image.value().pixels.data(), image.value().pixels.size());
    return values;
  }
};

TEST_F(BlockTextures, RenderAsPngFilesDo) {
  for (const Format& format : kFormats) write_texture(format);
  write_gltf(".ktx2");
  write_gltf(".png");
  const std::vector<float> blocks = render(".ktx2"), png = render(".png");
  ASSERT_EQ(blocks.size(), png.size());
  ASSERT_EQ(blocks.size() % (110 * 44), 0U);
  const size_t channels = blocks.size() / (110 * 44);
  size_t index = 0;
  for (const Format& format : kFormats) {
    SCOPED_TRACE(format.name);
    const size_t left = 22 * (index % 5) + 3, top = index < 5 ? 24 : 2; // inside of its square
    ++index;
    double mean_blocks = 0.0, mean_png = 0.0, variation = 0.0, largest = 0.0;
    for (size_t y = top; y < top + 16; ++y)
      for (size_t x = left; x < left + 16; ++x)
        for (size_t c = 0; c < 3; ++c) {
          const double a = static_cast<double>(blocks[(110 * y + x) * channels + c]);
          const double b = static_cast<double>(png[(110 * y + x) * channels + c]);
          mean_blocks += a / 768;
          mean_png += b / 768;
          variation += std::abs(b - static_cast<double>(png[(110 * y + x + 2) * channels + c])) / 768;
          largest = std::max(largest, std::abs(a - b));
        }
    EXPECT_GT(variation, 0.002) << "the texture is not seen";
    EXPECT_NEAR(mean_blocks, mean_png, 1e-5 * mean_png);
    // Colors of 8 bits are the same texels. Directions of 11 bits may be rounded by 2^-16 on their
    // way into the PNG, which moves reflections.
    EXPECT_LE(largest, format.normals ? 1e-3 : 0.0);
  }
}

} // namespace
} // namespace kindling::test
