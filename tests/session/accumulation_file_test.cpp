// Accumulation files survive a round trip, and damage to them is detected.
// SPDX-License-Identifier: Apache-2.0
#include "tests/session/test_accumulation.h"

#include <fstream>
#include <random>
#include <vector>

namespace kindling::test {
namespace {

namespace fs = std::filesystem;

class AccumulationFile : public AccumulationFolder {};

TEST_F(AccumulationFile, RoundTripKeepsEverything) {
  const V2i size(200, 130); // planes of several blocks
  const PixelRect area{V2i(3, 5), V2i(197, 130)};
  for (const bool everything : {false, true}) {
    RenderState state = random_state(size, area, everything, 4);
    if (everything) state.work.training_paths = 12288;
    EXPECT_TRUE(state.adaptive.empty() || state.adaptive.fits(area)); // a precondition of writing
    const AccumulationIdentity identity = identity_of(size, area);
    const Result<void> written = write_accumulation(path_, identity, state, false);
    ASSERT_TRUE(written.ok()) << written.error().message;
    const Result<Accumulation> read = read_accumulation(path_);
    ASSERT_TRUE(read.ok()) << read.error().message;
    expect_same(read.value().state, state);
    expect_same(read.value().identity, identity);
    const Result<AccumulationSummary> summary = read_accumulation_summary(path_);
    ASSERT_TRUE(summary.ok()) << summary.error().message;
    expect_same(summary.value().identity, identity);
    EXPECT_EQ(summary.value().coverage, state.coverage);
    EXPECT_EQ(summary.value().work.thread_s, state.work.thread_s);
    EXPECT_EQ(summary.value().work.training_paths, state.work.training_paths);
  }
  EXPECT_EQ(files_in_folder(), 1U);
}

TEST_F(AccumulationFile, RoundTripWithoutPixels) {
  const PixelRect none{V2i(5, 5), V2i(5, 5)};
  ASSERT_TRUE(write_accumulation(path_, identity_of(kSmall, kSmallArea),
                                 RenderState{Film(kSmall, none, {}), Coverage(none), {}, {}}, false));
  const Result<Accumulation> read = read_accumulation(path_);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read.value().state.coverage.block_count(), 0U);
}

// In a film with few samples of a smooth image the upper bytes of sums are nearly equal.
TEST_F(AccumulationFile, IsSmallerThanTheFilm) {
  const V2i size(128, 128);
  const PixelRect area{V2i(0), size};
  RenderState state{Film(size, area, {}), Coverage(area), {}, {}};
  std::mt19937 random(3);
  for (int i = 0; i < 16 * 128 * 128; ++i) {
    const float y = static_cast<float>(random()) * 0x1p-32f;
    state.film.add({i % 128, i / 128 % 128}, {Rgb(y, 0.5f * y * y, 0.1f * y), 1.0f, 1.0f});
  }
  ASSERT_TRUE(write_accumulation(path_, identity_of(size, area), state, false).ok());
  EXPECT_LT(fs::file_size(path_), state.film.memory_bytes() / 2);
}

TEST_F(AccumulationFile, DetectsEachFlippedBit) {
  write_small(path_);
  const std::string good = contents(path_);
  std::mt19937 random(8);
  std::fstream file(path_, std::ios::binary | std::ios::in | std::ios::out);
  const auto put = [&](size_t at, char byte) { file.seekp(static_cast<std::streamoff>(at)).put(byte).flush(); };
  for (int i = 0; i < 500; ++i) {
    // A third of the bits each: anywhere, in the header, at the end.
    const size_t span = i % 3 == 0 ? good.size() : 1000;
    const size_t at = i % 3 == 2 ? good.size() - 1 - random() % span : random() % span;
    put(at, static_cast<char>(good[at] ^ (1 << random() % 8)));
    const Result<Accumulation> read = read_accumulation(path_);
    ASSERT_FALSE(read.ok()) << at;
    EXPECT_EQ(read.error().kind, ErrorKind::input_output);
    EXPECT_TRUE(read.error().message.starts_with(path_.string() + ": ")) << read.error().message;
    EXPECT_EQ(read.error().message.find('\n'), std::string::npos);
    put(at, good[at]);
  }
  expect_small(path_, 1);
}

TEST_F(AccumulationFile, DetectsEachTruncation) {
  write_small(path_);
  const std::string good = contents(path_);
  std::mt19937 random(9);
  std::vector<size_t> sizes{
      0, 1, 7, 8, 12, 16, 19, 20, 21, good.size() - 1, good.size() - 23, good.size() - 24, good.size() - 25};
  for (int i = 0; i < 200; ++i) sizes.push_back(random() % good.size());
  for (const size_t size : sizes) {
    set_contents(path_, std::string_view(good).substr(0, size));
    const Result<Accumulation> read = read_accumulation(path_);
    ASSERT_FALSE(read.ok()) << size;
    // This also checks the positions of blocks.
    EXPECT_FALSE(read_accumulation_summary(path_).ok()) << size;
  }
  set_contents(path_, good + "x");
  EXPECT_FALSE(read_accumulation(path_).ok());
}

TEST_F(AccumulationFile, ErrorsNamePlace) {
  write_small(path_);
  const std::string good = contents(path_);
  const auto message_of = [&](const std::string& bytes) {
    set_contents(path_, bytes);
    const Result<Accumulation> read = read_accumulation(path_);
    EXPECT_FALSE(read.ok());
    return read.ok() ? "" : read.error().message.substr(path_.string().size() + 2);
  };
  EXPECT_EQ(message_of("KND"), "is not an accumulation file: it is too short");
  EXPECT_EQ(message_of("KNDLRAYS" + good.substr(8)), "is not an accumulation file: it does not begin with KNDLACCU");
  std::string bad = good;
  bad[8] = 2;
  EXPECT_EQ(message_of(bad), "is an accumulation file of version 2; this program reads version 1");
  bad = good;
  bad[30] ^= 1;
  EXPECT_NE(message_of(bad).find("its header (bytes 0 to "), std::string::npos) << message_of(bad);
  bad = good;
  bad[bad.size() - 1000] ^= 1;
  EXPECT_NE(message_of(bad).find("(of plane 'mattes', at byte "), std::string::npos) << message_of(bad);
  EXPECT_NE(message_of(good.substr(0, good.size() / 2)).find("is cut off: it ends at byte "), std::string::npos);
  EXPECT_NE(message_of(good.substr(0, good.size() - 24)).find("is cut off: it ends at byte "), std::string::npos);
}

TEST_F(AccumulationFile, RefusesPathsThatAreNoFile) {
  EXPECT_FALSE(read_accumulation(folder_ / "none.kacc").ok());
  EXPECT_FALSE(read_accumulation(folder_).ok());
  EXPECT_FALSE(read_accumulation("/dev/zero").ok());
  EXPECT_FALSE(write_accumulation(folder_ / "none" / "a.kacc", identity_of(kSmall, kSmallArea),
                                  random_state(kSmall, kSmallArea, false, 1), true)
                   .ok());
}

} // namespace
} // namespace kindling::test
