// Tests of KTX2 decoding: agreement with the reference transcoder, refusal of invalid files.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/basis_lz_bits.h"
#include "renderer/image/decode_image.h"
#include "renderer/image/uastc_block.h"
#include "renderer/image/uastc_tables.h"

#include "tests/image/test_images.h"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cstring>
#include <random>
#include <set>

namespace kindling {
namespace {

using image_detail::BlockTexels;
using test::FileBytes;

FileBytes fixture(const std::string& name) {
  return test::read_file(KINDLING_SOURCE_DIR "/tests/image/ktx2/" + name + ".ktx2");
}

Image decoded_ktx2(const FileBytes& file) {
  Result<Image> image = decode_image(file, "test");
  EXPECT_TRUE(image.ok()) << (image.ok() ? "" : image.error().message);
  return image.ok() ? image.value() : Image{};
}

std::string ktx2_error(const FileBytes& file) {
  const Result<Image> image = decode_image(file, "some name");
  EXPECT_FALSE(image.ok());
  return image.ok() ? "" : image.error().message;
}

// Hash of the pixels, extended to RGBA.
uint64_t hash_rgba(const Image& image) {
  uint64_t hash = 0xcbf29ce484222325;
  const auto channels = static_cast<size_t>(image.channels);
  for (size_t pixel = 0; pixel * channels < image.pixels.size(); ++pixel) {
    for (size_t c = 0; c < 4; ++c) {
      const uint64_t value = c < channels ? static_cast<uint64_t>(image.pixels[pixel * channels + c]) : 255;
      hash = (hash ^ value) * 0x100000001b3;
    }
  }
  return hash;
}

void put_u32(FileBytes& file, size_t at, uint32_t value) { std::memcpy(file.data() + at, &value, sizeof value); }
uint32_t get_u32(const FileBytes& file, size_t at) {
  uint32_t value = 0;
  std::memcpy(&value, file.data() + at, sizeof value);
  return value;
}

// Offsets in a KTX2 file (KTX 2.0, section 3).
constexpr size_t kVkFormat = 12, kWidth = 20, kHeight = 24, kDepth = 28, kLayers = 32, kFaces = 36, kLevels = 40,
                 kScheme = 44, kDescriptorOffset = 48, kKeyValueOffset = 56, kKeyValueLength = 60, kGlobalsOffset = 64,
                 kLevelOffset = 80, kLevelLength = 88, kInflatedLength = 96;

// Offset of a byte of the basic descriptor block: 8 is the color model, 11 the flags, 27 and 43 are
// the channels of the two samples.
std::byte& descriptor(FileBytes& file, size_t at) { return file[get_u32(file, kDescriptorOffset) + 4 + at]; }

FileBytes with_key_value(FileBytes file, std::string_view key, std::string_view value) {
  std::string entry(4, '\0');
  entry += key;
  entry += '\0';
  entry += value;
  entry += '\0';
  const auto length = static_cast<uint32_t>(entry.size() - 4);
  std::memcpy(entry.data(), &length, sizeof length);
  put_u32(file, kKeyValueOffset, static_cast<uint32_t>(file.size()));
  put_u32(file, kKeyValueLength, static_cast<uint32_t>(entry.size()));
  for (const char c : entry) file.push_back(static_cast<std::byte>(c));
  return file;
}

FileBytes patched(FileBytes file, size_t at, uint32_t value) {
  put_u32(file, at, value);
  return file;
}

const std::vector<std::string> kAllFixtures = {"uastc_modes", "uastc_zstd_rgba", "uastc_zstd_rgb", "etc1s_rgba",
                                               "etc1s_rgb",   "etc1s_flat",      "etc1s_gray"};

// ---- agreement

TEST(Ktx2, MatchesReferenceTranscoder) {
  struct Reference {
    const char* name;
    int width, height, channels;
    uint64_t hash;
  };
  for (const Reference& reference : {Reference{"uastc_modes", 72, 68, 4, 0x6604f0bdc6b8c9d1},
                                     {"uastc_zstd_rgba", 37, 22, 4, 0x32b2f6684956829},
                                     {"uastc_zstd_rgb", 5, 7, 3, 0xfacd2eb5f7087c4a},
                                     {"etc1s_rgba", 37, 22, 4, 0x2fd7db61fc8d6bb0},
                                     {"etc1s_rgb", 64, 64, 3, 0x61051101c44a70a4},
                                     {"etc1s_flat", 256, 256, 3, 0xf26fa72049f81aa5},
                                     {"etc1s_gray", 48, 48, 3, 0x74ff937e6e891d63}}) {
    const Image image = decoded_ktx2(fixture(reference.name));
    EXPECT_EQ(image.width, reference.width) << reference.name;
    EXPECT_EQ(image.height, reference.height) << reference.name;
    EXPECT_EQ(image.channels, reference.channels) << reference.name;
    EXPECT_EQ(image.type, PixelType::u8) << reference.name;
    EXPECT_EQ(hash_rgba(image), reference.hash) << reference.name;
  }
}

// The coverage of the test above.
TEST(Ktx2, UastcFixtureHasAllModesAndPatterns) {
  const FileBytes file = fixture("uastc_modes");
  std::set<int> modes;
  std::set<std::pair<int, const image_detail::UastcPattern*>> patterns;
  for (size_t at = get_u32(file, kLevelOffset); at + 16 <= file.size(); at += 16) {
    const uint64_t low = get_u32(file, at) | static_cast<uint64_t>(get_u32(file, at + 4)) << 32;
    const int mode = image_detail::uastc_mode_of(static_cast<uint32_t>(low));
    ASSERT_NE(mode, image_detail::kUastcReservedMode);
    modes.insert(mode);
    const image_detail::UastcMode& m = image_detail::kUastcMode[static_cast<size_t>(mode)];
    if (m.subsets < 2) continue;
    const auto index = static_cast<uint32_t>(low >> (m.code_bits + m.hint_bits));
    patterns.emplace(mode,
                     image_detail::uastc_pattern(mode, index & ((1U << image_detail::uastc_pattern_bits(m)) - 1U)));
  }
  EXPECT_EQ(modes.size(), 19U);
  EXPECT_EQ(patterns.size(), 4 * 30U + 11U + 19U);
}

// ---- UASTC

// Compares the first patterns of the three tables in the UASTC specification.
TEST(Uastc, PatternsMatchSpecification) {
  using Subsets = std::array<uint8_t, 16>;
  EXPECT_EQ(image_detail::uastc_pattern(2, 0)->subset, (Subsets{0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1}));
  EXPECT_EQ(image_detail::uastc_pattern(2, 29)->subset, (Subsets{1, 0, 0, 1, 0, 0, 1, 1, 0, 1, 1, 0, 1, 1, 0, 0}));
  EXPECT_EQ(image_detail::uastc_pattern(2, 29)->anchors, (std::array<uint8_t, 3>{1, 0, 0}));
  EXPECT_EQ(image_detail::uastc_pattern(3, 0)->subset, (Subsets{0, 0, 0, 0, 0, 0, 0, 0, 1, 1, 2, 2, 1, 1, 2, 2}));
  EXPECT_EQ(image_detail::uastc_pattern(3, 0)->anchors, (std::array<uint8_t, 3>{0, 8, 10}));
  EXPECT_EQ(image_detail::uastc_pattern(7, 0)->subset, (Subsets{0, 0, 0, 0, 1, 1, 1, 1, 0, 0, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(image_detail::uastc_pattern(2, 30), nullptr);
  EXPECT_EQ(image_detail::uastc_pattern(3, 11), nullptr);
  EXPECT_EQ(image_detail::uastc_pattern(7, 19), nullptr);
}

// Returns a block made of fields (value, bits), lowest first.
std::array<std::byte, 16> make_block(const std::vector<std::pair<uint32_t, int>>& fields) {
  std::array<std::byte, 16> block{};
  size_t at = 0;
  for (const auto& [value, bits] : fields) {
    for (int i = 0; i < bits; ++i, ++at) block[at / 8] |= static_cast<std::byte>((value >> i & 1U) << (at % 8));
  }
  return block;
}

TEST(Uastc, DecodesSolidBlock) {
  BlockTexels texels;
  ASSERT_TRUE(image_detail::decode_uastc_block(make_block({{0x17, 5}, {1, 8}, {2, 8}, {3, 8}, {200, 8}}), texels));
  for (const auto& texel : texels) EXPECT_EQ(texel, (std::array<uint8_t, 4>{1, 2, 3, 200}));
}

// Mode 17 has luminance and alpha with 8-bit endpoints and two planes of 2-bit weights: 0, 21, 43
// and 64.
TEST(Uastc, DecodesLuminanceAlphaInTwoPlanes) {
  std::vector<std::pair<uint32_t, int>> fields = {{0x25, 6}, {0, 23}, {0, 8}, {255, 8}, {255, 8}, {10, 8}};
  for (uint32_t i = 0; i < 16; ++i) {
    fields.emplace_back(i == 0 ? 1 : i % 4, i == 0 ? 1 : 2); // the first weight of each plane has one bit less
    fields.emplace_back(i == 0 ? 0 : 3 - i % 4, i == 0 ? 1 : 2);
  }
  BlockTexels texels;
  ASSERT_TRUE(image_detail::decode_uastc_block(make_block(fields), texels));
  const auto blend = [](double low, double high, double weight) { // in 16 bits, of which the upper half is kept
    return static_cast<uint8_t>(
        std::floor(std::floor((low * 257 * (64 - weight) + high * 257 * weight + 32) / 64) / 256));
  };
  constexpr std::array<double, 4> kWeights = {0, 21, 43, 64};
  for (uint32_t i = 0; i < 16; ++i) {
    const uint8_t luminance = blend(0, 255, kWeights[i == 0 ? 1 : i % 4]);
    const uint8_t alpha = blend(255, 10, kWeights[i == 0 ? 0 : 3 - i % 4]);
    EXPECT_EQ(texels[i], (std::array<uint8_t, 4>{luminance, luminance, luminance, alpha})) << i;
  }
}

TEST(Uastc, RefusesInvalidBlocks) {
  BlockTexels texels;
  EXPECT_FALSE(image_detail::decode_uastc_block(make_block({{0x45, 7}}), texels)) << "reserved mode";
  EXPECT_FALSE(image_detail::decode_uastc_block(make_block({{0x1d, 5}, {0, 15}, {30, 5}}), texels)) << "pattern";
  EXPECT_FALSE(image_detail::decode_uastc_block(make_block({{0x01, 4}, {0, 15}, {243, 8}}), texels)) << "trits";
  EXPECT_FALSE(image_detail::decode_uastc_block(make_block({{0x13, 5}, {0, 15}, {0, 5}, {125, 7}}), texels))
      << "quints";
  FileBytes file = fixture("uastc_modes");
  file[get_u32(file, kLevelOffset) + 16] = std::byte{0x45};
  EXPECT_EQ(ktx2_error(file), "some name: cannot decode KTX2: its UASTC block (1, 0) is invalid");
}

TEST(Ktx2, ZlibEqualsUncompressed) {
  FileBytes file = fixture("uastc_modes");
  const size_t at = get_u32(file, kLevelOffset), length = get_u32(file, kLevelLength);
  std::vector<Bytef> packed(compressBound(length));
  uLongf packed_length = packed.size();
  ASSERT_EQ(compress(packed.data(), &packed_length, reinterpret_cast<const Bytef*>(file.data() + at), length), Z_OK);
  const Image plain = decoded_ktx2(file);
  file.resize(at + packed_length);
  std::memcpy(file.data() + at, packed.data(), packed_length);
  put_u32(file, kScheme, 3);
  put_u32(file, kLevelLength, static_cast<uint32_t>(packed_length));
  EXPECT_TRUE(decoded_ktx2(file).pixels == plain.pixels);
  file[at + packed_length / 2] ^= std::byte{255};
  EXPECT_NE(ktx2_error(file).find("its zlib data are corrupt"), std::string::npos);
}

// ---- channels

// Green is stored in place of alpha: RRRG of UASTC, RRR and GGG of ETC1S.
TEST(Ktx2, RedGreenTexturesDecodeToTheirChannels) {
  for (const std::string name : {"uastc_modes", "etc1s_rgba"}) {
    FileBytes file = fixture(name);
    const Image rgba = decoded_ktx2(file);
    if (name == "uastc_modes") {
      descriptor(file, 27) = std::byte{5};
    } else {
      descriptor(file, 27) = std::byte{3};
      descriptor(file, 43) = std::byte{4};
    }
    const Image image = decoded_ktx2(file);
    ASSERT_EQ(image.channels, 3);
    for (size_t pixel = 0; pixel * 4 < rgba.pixels.size(); ++pixel) {
      ASSERT_EQ(image.pixels[3 * pixel], rgba.pixels[4 * pixel]);
      ASSERT_EQ(image.pixels[3 * pixel + 1], rgba.pixels[4 * pixel + 3]);
      ASSERT_EQ(image.pixels[3 * pixel + 2], std::byte{0});
    }
  }
}

TEST(Ktx2, OpaqueTexturesHaveNoAlpha) {
  FileBytes file = fixture("uastc_modes");
  const Image rgba = decoded_ktx2(file);
  for (const uint8_t channel : {0, 4, 6}) { // RGB, RRR, RG
    descriptor(file, 27) = static_cast<std::byte>(channel);
    const Image image = decoded_ktx2(file);
    ASSERT_EQ(image.channels, 3);
    EXPECT_EQ(image.pixels[3 * 100 + 2], rgba.pixels[4 * 100 + 2]);
  }
  descriptor(file, 27) = std::byte{9};
  EXPECT_NE(ktx2_error(file).find("its 1 samples are not those of"), std::string::npos);
}

// ---- features that glTF does not allow

TEST(Ktx2, RefusesFeaturesBeyondGltf) {
  const FileBytes uastc = fixture("uastc_modes"), etc1s = fixture("etc1s_rgb");
  const auto refused = [](const FileBytes& file, std::string_view part) {
    const std::string message = ktx2_error(file);
    EXPECT_EQ(message.find("some name: cannot decode KTX2: "), 0U) << message;
    EXPECT_NE(message.find(part), std::string::npos) << message;
  };
  refused(patched(uastc, kVkFormat, 37), "its level 0 has 4896 bytes where 72 x 68 pixels need 19584");
  refused(patched(uastc, kFaces, 6), "it is a cube map (depth 0, 0 layers, 6 faces); accepted is a single 2-D image");
  refused(patched(uastc, kLayers, 2), "it is an array (depth 0, 2 layers, 1 faces)");
  refused(patched(uastc, kDepth, 4), "it is a volume (depth 4, 0 layers, 1 faces)");
  refused(patched(uastc, kHeight, 0), "level 0 has 4896 bytes where 72 x 0 pixels need 0");
  refused(patched(uastc, kLevels, 8), "8 levels are more than 72 x 68 pixels have");
  refused(patched(uastc, kScheme, 1), "its UASTC data have supercompression scheme 1");
  refused(patched(etc1s, kScheme, 2), "its ETC1S data have supercompression scheme 2; accepted is 1 (BasisLZ)");
  refused(patched(uastc, kScheme, 9), "its supercompression scheme is 9");
  FileBytes file = uastc;
  descriptor(file, 8) = std::byte{167};
  refused(file, "its color model is 167; accepted are 163 (ETC1S) and 166 (UASTC LDR)");
  file = uastc;
  descriptor(file, 11) = std::byte{1};
  refused(file, "its alpha is premultiplied; use straight alpha");
  refused(with_key_value(uastc, "KTXswizzle", "rrrg"), "its KTXswizzle is 'rrrg'; accepted is 'rgba'");
  refused(with_key_value(uastc, "KTXorientation", "ru"), "its KTXorientation is 'ru'; accepted is 'rd'");
  file = etc1s;
  file[get_u32(file, kGlobalsOffset) + 20] = std::byte{2};
  refused(file, "it is a video frame that depends on another");

  const Image plain = decoded_ktx2(uastc);
  EXPECT_TRUE(decoded_ktx2(with_key_value(uastc, "KTXswizzle", "rgba")).pixels == plain.pixels);
  EXPECT_TRUE(decoded_ktx2(with_key_value(uastc, "KTXorientation", "rd")).pixels == plain.pixels);
  EXPECT_TRUE(decoded_ktx2(with_key_value(uastc, "KTXwriter", "somebody")).pixels == plain.pixels);
}

// ---- damage

TEST(Ktx2, RefusesPartsOutsideOfFile) {
  const FileBytes file = fixture("uastc_modes"), etc1s = fixture("etc1s_rgba");
  for (const size_t at : {kDescriptorOffset, kKeyValueOffset, kGlobalsOffset, kLevelOffset}) {
    for (const uint32_t value : {static_cast<uint32_t>(file.size()) + 1, 0xffffffffU}) {
      EXPECT_NE(ktx2_error(patched(file, at, value)).find("lies outside the file of 5056 bytes"), std::string::npos);
      EXPECT_NE(ktx2_error(patched(file, at, value)).find("cannot decode KTX2"), std::string::npos);
    }
  }
  EXPECT_NE(ktx2_error(patched(file, kLevelOffset + 4, 1)).find("outside"), std::string::npos) << "beyond 4 GiB";
  const size_t globals = get_u32(etc1s, kGlobalsOffset);
  EXPECT_NE(ktx2_error(patched(etc1s, globals + 8, 0xffffffff)).find("its BasisLZ data have"), std::string::npos);
  EXPECT_NE(ktx2_error(patched(etc1s, globals + 28, 0)).find("its slice (0 bytes"), std::string::npos);
  EXPECT_NE(ktx2_error(patched(etc1s, globals + 36, 0xffffff00)).find("its slice"), std::string::npos) << "alpha";
  EXPECT_NE(ktx2_error(patched(etc1s, globals, 0)).find("codebooks are empty"), std::string::npos);
}

// Small files with huge sizes are refused before memory is allocated.
TEST(Ktx2, RefusesSmallFilesOfHugeImages) {
  FileBytes file = fixture("uastc_zstd_rgb");
  put_u32(file, kWidth, 16384);
  put_u32(file, kHeight, 16384);
  put_u32(file, kInflatedLength, 16384U * 16384U);
  EXPECT_NE(ktx2_error(file).find("cannot hold 16384 x 16384 pixels"), std::string::npos);
  put_u32(file, kScheme, 3);
  EXPECT_NE(ktx2_error(file).find("cannot hold 16384 x 16384 pixels"), std::string::npos);
  put_u32(file, kScheme, 0);
  EXPECT_NE(ktx2_error(file).find("where 16384 x 16384 pixels need 268435456"), std::string::npos);
}

TEST(Ktx2, RefusesTruncatedFiles) {
  for (const std::string& name : kAllFixtures) {
    const FileBytes file = fixture(name);
    for (size_t length = 0; length < file.size(); ++length) {
      ASSERT_FALSE(decode_image(std::span(file).first(length), "cut").ok()) << name << " cut at " << length;
    }
  }
}

// Any result is correct except a crash, a hang or memory beyond the limit. This test is also run
// with sanitizers.
TEST(Ktx2, SurvivesFlippedBytes) {
  ImageLimits limits;
  limits.max_pixels = 1 << 16;
  std::mt19937 random(7);
  size_t refused = 0, accepted = 0;
  for (const std::string& name : kAllFixtures) {
    const FileBytes file = fixture(name);
    const int rounds = name == "etc1s_flat" ? 200 : 1000; // it has many pixels
    for (int round = 0; round < rounds; ++round) {
      FileBytes damaged = file;
      // A third of the rounds modifies header and descriptor, a third the codebooks, a third any
      // byte.
      const size_t globals = get_u32(file, kGlobalsOffset);
      const size_t from = round % 3 == 1 ? globals : 0;
      const size_t range = round % 3 == 2 ? file.size() : std::min<size_t>(file.size() - from, 300);
      for (uint32_t i = 1 + random() % 4; i > 0; --i)
        damaged[from + random() % range] = static_cast<std::byte>(random());
      const Result<Image> image = decode_image(damaged, "damaged", limits);
      ++(image.ok() ? accepted : refused);
      if (image.ok()) {
        EXPECT_EQ(image.value().pixels.size(), image.value().byte_count());
      } else {
        EXPECT_EQ(image.error().message.find('\n'), std::string::npos);
      }
    }
  }
  EXPECT_GT(refused, 1000U);
  EXPECT_GT(accepted, 500U);
}

// ---- Huffman codes

TEST(BasisLz, HuffmanCodesAreCanonical) {
  // The example of RFC 1951, 3.2.2: A to H have 3, 3, 3, 3, 3, 2, 4 and 4 bits; codes 010 ... 110,
  // 00, 1110, 1111.
  const std::array<uint8_t, 8> lengths = {3, 3, 3, 3, 3, 2, 4, 4};
  const auto table = image_detail::HuffmanTable::from_lengths(lengths);
  ASSERT_TRUE(table);
  // H, F, A, G with the highest bit of each code first: 1111 00 010 1110, then only zeros.
  const std::array<std::byte, 2> stream = {std::byte{0b10001111}, std::byte{0b01110}};
  image_detail::BitReader bits(stream);
  EXPECT_EQ(table->decode(bits), 7U);
  EXPECT_EQ(table->decode(bits), 5U);
  EXPECT_EQ(table->decode(bits), 0U);
  EXPECT_EQ(table->decode(bits), 6U);
  EXPECT_TRUE(bits.ok());
  EXPECT_EQ(table->decode(bits), 5U);
  EXPECT_EQ(table->decode(bits), 5U);
  EXPECT_FALSE(bits.ok()) << "past the end";
}

TEST(BasisLz, RefusesImpossibleHuffmanCodes) {
  const std::array<uint8_t, 3> too_many = {1, 1, 1}, one = {0, 1, 0};
  EXPECT_FALSE(image_detail::HuffmanTable::from_lengths(too_many));
  const auto table = image_detail::HuffmanTable::from_lengths(one);
  ASSERT_TRUE(table);
  const std::array<std::byte, 1> stream = {std::byte{0b10}};
  image_detail::BitReader bits(stream);
  EXPECT_EQ(table->decode(bits), 1U);
  EXPECT_TRUE(bits.ok());
  (void)table->decode(bits);
  EXPECT_FALSE(bits.ok()) << "the code 1 is unused";
  image_detail::BitReader others(stream);
  EXPECT_EQ(image_detail::HuffmanTable().decode(others), 0U);
  EXPECT_FALSE(others.ok()) << "a table without codes";
}

} // namespace
} // namespace kindling
