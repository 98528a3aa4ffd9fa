// Rays from .npz files as numpy writes them, and damaged ones.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/npz_rays.h"

#include <gtest/gtest.h>

#include <zlib.h>

#include <cstring>
#include <fstream>
#include <limits>

#include <unistd.h>

namespace kindling::test {
namespace {

template <typename Number>
std::string raw(Number number) {
  std::string text(sizeof number, '\0');
  std::memcpy(text.data(), &number, sizeof number);
  return text;
}

std::string npy(const std::string& descr, const std::string& shape, const std::string& data, bool fortran = false) {
  std::string header =
      "{'descr': '" + descr + "', 'fortran_order': " + (fortran ? "True" : "False") + ", 'shape': " + shape + ", }";
  header += std::string(64 - (header.size() + 11) % 64, ' ') + "\n";
  return "\x93NUMPY" + std::string("\x01\x00", 2) + raw(static_cast<uint16_t>(header.size())) + header + data;
}

template <typename Number>
std::string numbers(const std::vector<Number>& values) {
  return {reinterpret_cast<const char*>(values.data()), values.size() * sizeof(Number)};
}

using Members = std::vector<std::pair<std::string, std::string>>;

std::string zip(const Members& members, bool compress = false) {
  std::string file, directory;
  for (const auto& [name, contents] : members) {
    std::string stored = contents;
    if (compress) {
      z_stream stream{};
      EXPECT_EQ(deflateInit2(&stream, 6, Z_DEFLATED, -MAX_WBITS, 8, Z_DEFAULT_STRATEGY), Z_OK);
      stored.resize(contents.size() + 1000);
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(contents.data()));
      stream.avail_in = static_cast<uInt>(contents.size());
      stream.next_out = reinterpret_cast<Bytef*>(stored.data());
      stream.avail_out = static_cast<uInt>(stored.size());
      EXPECT_EQ(deflate(&stream, Z_FINISH), Z_STREAM_END);
      stored.resize(stream.total_out);
      deflateEnd(&stream);
    }
    const auto crc = static_cast<uint32_t>(
        crc32(0, reinterpret_cast<const Bytef*>(contents.data()), static_cast<uInt>(contents.size())));
    const std::string common = raw(uint16_t{20}) + raw(uint16_t{0}) + raw(static_cast<uint16_t>(compress ? 8 : 0)) +
                               raw(uint32_t{0}) + raw(crc) + raw(static_cast<uint32_t>(stored.size())) +
                               raw(static_cast<uint32_t>(contents.size())) + raw(static_cast<uint16_t>(name.size()));
    const auto local = static_cast<uint32_t>(file.size());
    file += "PK\x03\x04" + common + raw(uint16_t{20}) + name + std::string(20, '\0') + stored; // with an extra field
    directory += "PK\x01\x02" + raw(uint16_t{20}) + common + raw(uint16_t{0}) + raw(uint16_t{0}) + raw(uint16_t{0}) +
                 raw(uint16_t{0}) + raw(uint32_t{0}) + raw(local) + name;
  }
  const auto begin = static_cast<uint32_t>(file.size());
  return file + directory + "PK\x05\x06" + raw(uint32_t{0}) + raw(static_cast<uint16_t>(members.size())) +
         raw(static_cast<uint16_t>(members.size())) + raw(static_cast<uint32_t>(directory.size())) + raw(begin) +
         raw(uint16_t{0});
}

Members rays() {
  return {{"origins.npy", npy("<f4", "(2, 3)", numbers<float>({1, 2, 3, 4, 5, 6}))},
          {"directions.npy", npy("<f8", "(2, 3)", numbers<double>({0, 0, 1, 0, -1, 0}))}};
}

class NpzRays : public testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  Result<RayRecording> read(const std::string& contents) const {
    std::ofstream(path_, std::ios::binary) << contents;
    return read_npz_rays(path_);
  }
  std::string error(const std::string& contents) const {
    const Result<RayRecording> rays = read(contents);
    if (rays.ok()) return {};
    EXPECT_EQ(rays.error().kind, ErrorKind::input_output);
    EXPECT_TRUE(rays.error().message.starts_with(path_.string() + ": ")) << rays.error().message;
    return rays.error().message.substr(path_.string().size() + 2);
  }
  std::string error(const Members& members) const { return error(zip(members)); }

  std::filesystem::path path_ =
      std::filesystem::path(testing::TempDir()) / ("kindling_" + std::to_string(getpid()) + ".npz");
};

TEST_F(NpzRays, ArraysBecomeTwoSets) {
  for (const bool compress : {false, true}) {
    const Result<RayRecording> read_rays = read(zip(rays(), compress));
    ASSERT_TRUE(read_rays.ok()) << read_rays.error().message;
    EXPECT_EQ(read_rays.value().geometry_hash, 0U);
    ASSERT_EQ(read_rays.value().sets.size(), 2U);
    EXPECT_EQ(read_rays.value().sets[0].query, RayQuery::nearest);
    EXPECT_EQ(read_rays.value().sets[1].query, RayQuery::any_hit);
    for (const RaySet& set : read_rays.value().sets) {
      ASSERT_EQ(set.rays.size(), 2U);
      EXPECT_EQ(set.rays[0].origin, V3f(1, 2, 3));
      EXPECT_EQ(set.rays[1].direction, V3f(0, -1, 0));
      EXPECT_EQ(set.rays[1].t_min, 0.0f);
      EXPECT_EQ(set.rays[1].t_max, std::numeric_limits<float>::infinity());
    }
  }
}

TEST_F(NpzRays, OptionalArraysAndOrdersAreRead) {
  Members members = rays();
  members[0].second = npy("<f4", "(2, 3)", numbers<float>({1, 4, 2, 5, 3, 6}), true);
  std::string turned = numbers<float>({0.5f, 7.0f});
  for (const size_t i : {0, 4}) std::reverse(turned.begin() + i, turned.begin() + i + 4);
  members.emplace_back("t_max.npy", npy(">f4", "(2,)", turned));
  members.emplace_back("t_min.npy", npy("<f8", "()", numbers<double>({0.25})));
  members.emplace_back("comment.npy", "anything");
  const Result<RayRecording> read_rays = read(zip(members));
  ASSERT_TRUE(read_rays.ok()) << read_rays.error().message;
  const std::vector<accel::Ray>& found = read_rays.value().sets[0].rays;
  EXPECT_EQ(found[1].origin, V3f(4, 5, 6));
  EXPECT_EQ(found[0].t_max, 0.5f);
  EXPECT_EQ(found[1].t_max, 7.0f);
  EXPECT_EQ(found[1].t_min, 0.25f);
}

TEST_F(NpzRays, WrongArraysAreNamed) {
  Members members = rays();
  EXPECT_EQ(error(Members{members[0]}), "has no array 'directions'; origins and directions of shape (N, 3) are needed");
  members[1].second = npy("<f4", "(3, 3)", numbers<float>({1, 0, 0, 1, 0, 0, 1, 0, 0}));
  EXPECT_EQ(error(members), "has 2 origins and 3 directions");
  members[1].second = npy("<f4", "(6,)", numbers<float>({1, 0, 0, 1, 0, 0}));
  EXPECT_EQ(error(members), "array directions has the shape (6,), expected (N, 3)");
  members[1].second = npy("<i4", "(2, 3)", numbers<float>({1, 0, 0, 1, 0, 0}));
  EXPECT_EQ(error(members), "array directions has the type '<i4'; float32 and float64 can be read");
  members[1].second = npy("<f4", "(2, 3)", numbers<float>({1, 0, 0, 1, 0}));
  EXPECT_EQ(error(members), "array directions of shape (2, 3) has 20 bytes");
  members[1].second = npy("<f4", "(99999999999999999999, 3)", "");
  EXPECT_EQ(error(members), "array directions is too large; at most 16777216 rays are read");
  members[1].second = npy("<f4", "(2, 3, 1)", numbers<float>({1, 0, 0, 1, 0, 0}));
  EXPECT_EQ(error(members), "array directions has more than two dimensions");
  members[1].second = npy("<f4", "(2, -3)", numbers<float>({1, 0, 0, 1, 0, 0}));
  EXPECT_EQ(error(members), "array directions has a damaged shape");
  members[1].second = npy("<f4", "(0, 3)", "");
  EXPECT_EQ(error(members), "has 2 origins and 0 directions");
  members[1].second = npy("<f4", "(2, 3)", numbers<float>({1, 0, 0, 0, 0, 0}));
  EXPECT_NE(error(members).find("ray 1 is none: origin and direction must be finite"), std::string::npos);
  members = rays();
  members.emplace_back("t_max.npy", npy("<f4", "(3,)", numbers<float>({1, 2, 3})));
  EXPECT_EQ(error(members), "array t_max has the shape (3,), expected (2,)");
}

TEST_F(NpzRays, DamagedArchivesAreRefused) {
  EXPECT_EQ(error("KNDLRAYS"), "is no .npz file, or is cut off: it has no directory of a zip archive");
  std::string flipped = zip(rays());
  flipped[200] = static_cast<char>(flipped[200] ^ 1);
  EXPECT_EQ(error(flipped), "has a damaged array origins");
  for (const bool compress : {false, true}) {
    const std::string good = zip(rays(), compress);
    for (size_t i = 0; i < good.size(); ++i) {
      (void)error(good.substr(0, i));
      std::string changed = good;
      changed[i] = static_cast<char>(changed[i] ^ (1 << i % 8));
      (void)error(changed);
    }
  }
  Members two = rays();
  two.push_back(two[0]);
  EXPECT_EQ(error(two), "has two arrays origins");
  EXPECT_EQ(error(""), "is no .npz file, or is cut off: it has no directory of a zip archive");
  EXPECT_FALSE(read_npz_rays("/no/such/file.npz").ok());
  EXPECT_FALSE(read_npz_rays(testing::TempDir()).ok());
}

// A file of more than the budget is refused before it is read, and so are arrays that would unpack
// to more.
TEST_F(NpzRays, LargeFilesAreRefused) {
  std::ofstream(path_, std::ios::binary).close();
  std::filesystem::resize_file(path_, (uint64_t{1} << 30) + 1); // a hole
  const Result<RayRecording> large = read_npz_rays(path_);
  ASSERT_FALSE(large.ok());
  EXPECT_EQ(large.error().message,
            path_.string() +
                ": has 1073741825 bytes; at most 1073741824 (1 GiB) are read: write fewer rays, or float32");
  std::string file = zip(rays(), true);
  for (size_t entry = file.find("PK\x01\x02"); entry != std::string::npos; entry = file.find("PK\x01\x02", entry + 1))
    file.replace(entry + 24, 4, raw(uint32_t{0x20000001U}));
  EXPECT_EQ(error(file),
            "has arrays of 1073741826 bytes; at most 1073741824 (1 GiB) are read: write fewer rays, or float32");
  // The largest number of rays is that of a shape, whatever the data.
  Members members = rays();
  members[0].second = npy("<f4", "(16777216, 3)", "");
  EXPECT_EQ(error(members), "array origins of shape (16777216, 3) has 0 bytes");
  members[0].second = npy("<f4", "(16777217, 3)", "");
  EXPECT_EQ(error(members), "array origins is too large; at most 16777216 rays are read");
}

// Sizes of 4 GiB in the directory of a small file allocate nothing.
TEST_F(NpzRays, DeclaredSizesAreNotBelieved) {
  for (const bool compress : {false, true}) {
    std::string file = zip(rays(), compress);
    const size_t entry = file.find("PK\x01\x02");
    for (const size_t field : {size_t{20}, size_t{24}}) {
      std::string changed = file;
      changed.replace(entry + field, 4, raw(uint32_t{0xfffffff0U}));
      EXPECT_NE(error(changed), "") << compress << field;
    }
  }
  EXPECT_EQ(error(Members(65, {"other.npy", ""})), "has 65 arrays; at most 64 are read");
}

} // namespace
} // namespace kindling::test
