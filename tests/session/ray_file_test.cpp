// Ray files survive a round trip, and broken ones are refused with a reason.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/ray_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstring>
#include <fstream>
#include <limits>

namespace kindling::test {
namespace {

class RayFile : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (std::filesystem::temp_directory_path() / "kindling_rays_XXXXXX").string();
    ASSERT_NE(mkdtemp(name.data()), nullptr);
    folder_ = name;
    path_ = folder_ / "rays.bin";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  static RayRecording recording() {
    RayRecording out;
    out.geometry_hash = 0x0123456789abcdefULL;
    out.size_px = V2i(640, 360);
    RaySet camera{"camera", RayQuery::nearest, 64, {}};
    for (int i = 0; i < 100; ++i)
      camera.rays.push_back({.origin = V3f(0.1f * static_cast<float>(i), 2.0f, -3.0f),
                             .t_min = 0.0f,
                             .direction = V3f(0.0f, 0.6f, 0.8f),
                             .t_max = std::numeric_limits<float>::infinity(),
                             .key = static_cast<uint32_t>(i),
                             .time = 0.25f,
                             .index = 7,
                             .flags = 1});
    RaySet shadow{"shadow1", RayQuery::any_hit, 0, {camera.rays[3], camera.rays[5]}};
    out.sets = {camera, shadow, {"bounce3", RayQuery::nearest, 0, {}}};
    return out;
  }

  std::string bytes() const {
    std::ifstream file(path_, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  void write_bytes(const std::string& bytes) const { std::ofstream(path_, std::ios::binary) << bytes; }

  // Changes a good file, and expects these words in the error of reading it.
  template <typename Change>
  void expect_refused(const std::string& words, Change change) const {
    ASSERT_TRUE(write_ray_file(path_, recording()).ok());
    std::string changed = bytes();
    change(changed);
    write_bytes(changed);
    const Result<RayRecording> read = read_ray_file(path_);
    ASSERT_FALSE(read.ok()) << words;
    EXPECT_EQ(read.error().kind, ErrorKind::input_output);
    EXPECT_TRUE(read.error().message.starts_with(path_.string() + ": ")) << read.error().message;
    EXPECT_NE(read.error().message.find(words), std::string::npos) << read.error().message;
  }

  std::filesystem::path folder_;
  std::filesystem::path path_;
};

template <typename T>
void put(std::string& bytes, size_t at, T value) {
  std::memcpy(bytes.data() + at, &value, sizeof value);
}

// Documented offsets: a header of 32 bytes, 48 for each set, then rays of 48.
constexpr size_t kFirstSet = 32;
constexpr size_t kFirstRay = 32 + 3 * 48;

TEST_F(RayFile, RoundTripKeepsEverything) {
  const RayRecording written = recording();
  ASSERT_TRUE(write_ray_file(path_, written).ok());
  EXPECT_EQ(bytes().size(), kFirstRay + 102 * 48);
  const Result<RayRecording> read = read_ray_file(path_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().geometry_hash, written.geometry_hash);
  EXPECT_EQ(read.value().size_px, written.size_px);
  ASSERT_EQ(read.value().sets.size(), written.sets.size());
  for (size_t s = 0; s < written.sets.size(); ++s) {
    const RaySet &a = written.sets[s], &b = read.value().sets[s];
    EXPECT_EQ(a.name, b.name);
    EXPECT_EQ(a.query, b.query);
    EXPECT_EQ(a.coherent_group, b.coherent_group);
    ASSERT_EQ(a.rays.size(), b.rays.size());
    if (!a.rays.empty()) {
      EXPECT_EQ(std::memcmp(a.rays.data(), b.rays.data(), a.rays.size() * sizeof(accel::Ray)), 0);
    }
  }
}

TEST_F(RayFile, LayoutIsDocumented) {
  ASSERT_TRUE(write_ray_file(path_, recording()).ok());
  const std::string file = bytes();
  EXPECT_EQ(file.substr(0, 8), "KNDLRAYS");
  EXPECT_EQ(file.substr(kFirstSet, 7), std::string("camera\0", 7));
  uint64_t count = 0;
  std::memcpy(&count, file.data() + kFirstSet + 40, sizeof count);
  EXPECT_EQ(count, 100U);
  float t_max = 0.0f;
  std::memcpy(&t_max, file.data() + kFirstRay + 28, sizeof t_max);
  EXPECT_TRUE(std::isinf(t_max));
  uint32_t key = 0;
  std::memcpy(&key, file.data() + kFirstRay + 48 + 32, sizeof key); // of the second ray
  EXPECT_EQ(key, 1U);
}

TEST_F(RayFile, RefusesBrokenFiles) {
  expect_refused("is no ray file", [](std::string& b) { b[0] = 'X'; });
  expect_refused("is no ray file", [](std::string& b) { b.resize(20); });
  expect_refused("is no ray file", [](std::string& b) { b.clear(); });
  expect_refused("has version 9; version 1", [](std::string& b) { put<uint32_t>(b, 8, 9); });
  expect_refused("has 0 sets", [](std::string& b) { put<uint32_t>(b, 12, 0); });
  expect_refused("has 4294967295 sets", [](std::string& b) { put<uint32_t>(b, 12, 0xffffffffU); });
  expect_refused("ends within its table", [](std::string& b) { b.resize(kFirstSet + 50); });
  expect_refused("set 0: its name", [](std::string& b) { b[kFirstSet] = '\n'; });
  expect_refused("set 0: its name", [](std::string& b) { std::memset(b.data() + kFirstSet, 'a', 32); });
  expect_refused("set 1: query 2", [](std::string& b) { put<uint32_t>(b, kFirstSet + 48 + 32, 2); });
  expect_refused("groups of 4000000000", [](std::string& b) { put<uint32_t>(b, kFirstSet + 36, 4000000000U); });
  expect_refused("more than the file can hold", [](std::string& b) { put(b, kFirstSet + 40, ~uint64_t{0} / 3); });
  expect_refused("go with its header", [](std::string& b) { put<uint64_t>(b, kFirstSet + 40, 99); });
  expect_refused("go with its header", [](std::string& b) { b.pop_back(); });
  expect_refused("go with its header", [](std::string& b) { b += 'x'; });
  const float nan = std::nanf("");
  expect_refused("ray 1 of set 'camera'", [nan](std::string& b) { put(b, kFirstRay + 48, nan); });
  expect_refused("ray 0 of set 'camera'", [nan](std::string& b) { put(b, kFirstRay + 28, nan); });
  expect_refused("ray 0 of set 'shadow1'", [](std::string& b) {
    for (size_t k = 0; k < 3; ++k) put(b, kFirstRay + 100 * 48 + 16 + 4 * k, 0.0f);
  });
}

TEST_F(RayFile, RefusesMissingFilesAndFolders) {
  EXPECT_EQ(read_ray_file(folder_ / "none").error().message, (folder_ / "none").string() + ": cannot be read");
  EXPECT_NE(read_ray_file(folder_).error().message.find("is a folder"), std::string::npos);
  EXPECT_FALSE(write_ray_file(folder_ / "no" / "rays.bin", recording()).ok());
}

} // namespace
} // namespace kindling::test
