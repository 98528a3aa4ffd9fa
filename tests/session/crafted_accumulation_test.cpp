// Crafted files cannot make readers allocate more than they hold; files beyond 4 GiB are read.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/accumulation_layout.h"
#include "renderer/session/stored_block.h"
#include "tests/session/test_accumulation.h"

#include <nlohmann/json.hpp>

#include <cstring>
#include <fstream>
#include <limits>
#include <map>
#include <utility>

#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

namespace kindling::test {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

template <typename Record>
std::string bytes_of(const Record& record) {
  return {reinterpret_cast<const char*>(&record), sizeof record};
}

uint32_t checksum_of(std::string_view bytes, uint32_t before = 0) {
  return checksum(std::as_bytes(std::span(bytes)), before);
}

// Returns a file with this header and these blocks (each a BlockHeader and stored bytes), with
// correct checksums.
std::string file_of(std::string_view json, std::string_view blocks) {
  FileHead head;
  head.json_bytes = static_cast<uint32_t>(json.size());
  head.checksum = checksum_of(json, checksum_of(bytes_of(head).substr(0, offsetof(FileHead, checksum))));
  FileTail tail;
  tail.file_bytes = sizeof head + json.size() + blocks.size() + sizeof tail;
  uint32_t all = 0;
  for (size_t at = 0; at < blocks.size(); ++tail.blocks) {
    BlockHeader block;
    std::memcpy(&block, blocks.data() + at, sizeof block);
    all = checksum_of(bytes_of(block.checksum), all);
    at += sizeof block + block.stored_bytes;
  }
  tail.checksum = checksum_of(bytes_of(tail).substr(0, offsetof(FileTail, checksum)), all);
  std::string file = bytes_of(head);
  file.append(json).append(blocks).append(bytes_of(tail));
  return file;
}

// Limits memory as `ulimit -v` does. Not with sanitizers, which need the whole address space.
class LittleMemory {
 public:
  explicit LittleMemory(size_t bytes) {
    getrlimit(RLIMIT_AS, &before_);
    size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
    const rlimit little{pages * static_cast<size_t>(sysconf(_SC_PAGESIZE)) + bytes, before_.rlim_max};
    setrlimit(RLIMIT_AS, &little);
#else
    static_cast<void>(bytes);
#endif
  }
  ~LittleMemory() { setrlimit(RLIMIT_AS, &before_); }
  LittleMemory(const LittleMemory&) = delete;
  LittleMemory& operator=(const LittleMemory&) = delete;

 private:
  rlimit before_{};
};

class CraftedAccumulation : public AccumulationFolder {
 protected:
  void SetUp() override {
    AccumulationFolder::SetUp();
    write_small(path_);
    const std::string good = contents(path_);
    FileHead head;
    std::memcpy(&head, good.data(), sizeof head);
    json_ = Json::parse(good.substr(sizeof head, head.json_bytes));
    blocks_ =
        good.substr(sizeof head + head.json_bytes, good.size() - sizeof head - head.json_bytes - sizeof(FileTail));
    ASSERT_EQ(file_of(json_.dump(), blocks_), good);
  }

  // Returns the error of reading with 256 MiB of memory; empty if the file is good.
  [[nodiscard]] std::string message(std::string_view json, std::string_view blocks) {
    set_contents(path_, file_of(json, blocks));
    const LittleMemory little(size_t{256} << 20);
    const Result<AccumulationSummary> summary = read_accumulation_summary(path_);
    const Result<void> checked = check_accumulation(path_);
    const Result<Accumulation> read = read_accumulation(path_);
    EXPECT_EQ(read.ok(), checked.ok());
    if (read.ok()) return {};
    const std::string& text = read.error().message;
    EXPECT_EQ(read.error().kind, ErrorKind::input_output);
    EXPECT_TRUE(text.starts_with(path_.string() + ": ")) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    EXPECT_EQ(checked.error().message, text);
    if (!summary.ok()) {
      EXPECT_EQ(summary.error().message, text);
    }
    return text;
  }
  [[nodiscard]] std::string message(const Json& json) { return message(json.dump(), blocks_); }
  // Returns json_ with another area and everything that follows from it.
  [[nodiscard]] Json of_size(const V2i& size_px) const {
    Json json = json_;
    const PixelRect area{V2i(0), size_px};
    json["size"] = {size_px.x, size_px.y};
    json["crop"] = {0, 0, size_px.x, size_px.y};
    json["coverage"]["area"] = json["splats"] = json["crop"];
    const auto across = [](int pixels) { return (static_cast<uint64_t>(pixels) + kBlockSize - 1) / kBlockSize; };
    json["coverage"]["runs"] = {{across(size_px.x) * across(size_px.y), 0}};
    AccumulationHeader header;
    for (const AovInfo& info : kAovs) header.aovs.insert(info.aov);
    for (const Matte matte : {Matte::object, Matte::asset}) header.aovs.insert(matte); // as random_state() has them
    header.matte_terms = json["mattes"]["terms"];
    header.trims_outliers = header.adaptive = true;
    header.splat_area = area;
    json["planes"] = Json::array();
    for (const StoredPlane& plane : planes_of(header, area))
      json["planes"].push_back(
          {{"name", plane.name}, {"record_bytes", plane.record_bytes}, {"records", plane.records}});
    return json;
  }

  Json json_;          // of a good file
  std::string blocks_; // its blocks
};

testing::AssertionResult has_words(const std::string& message, const std::string& words) {
  if (message.find(words) != std::string::npos) return testing::AssertionSuccess();
  return testing::AssertionFailure() << "'" << words << "' is not in: " << message;
}

TEST_F(CraftedAccumulation, RefusesImagesLargerThanFile) {
  EXPECT_EQ(message(json_), "");
  for (const V2i& size : {V2i(1 << 20, 1 << 20), V2i(1 << 20, 1 << 10), V2i(4096, 4096)})
    EXPECT_TRUE(has_words(message(of_size(size)), "is cut off: it ends at byte "));
  EXPECT_TRUE(has_words(message(of_size(V2i(1 << 21, 8))), "'size' is not a whole number up to 1048576"));
  // One block more than the good file has.
  EXPECT_TRUE(has_words(message(of_size(V2i(40, 32))), "is damaged: its header claims "));
}

TEST_F(CraftedAccumulation, ErrorsHaveNoControlCharacters) {
  Json json = json_;
  json["aovs"].push_back("pos\ntion\x1b[2J");
  EXPECT_TRUE(has_words(message(json), R"(there is no AOV "pos\ntion\u001b[2J")"));
}

TEST_F(CraftedAccumulation, RefusesBlocksSmallerThanAnyFrame) {
  // 1 GiB of sums in 16 KiB: headers with nothing, or next to nothing, behind them.
  Json json = of_size(V2i(2048, 720));
  std::vector<StoredPlane> planes;
  for (const Json& plane : json["planes"])
    planes.push_back({plane["name"], plane["record_bytes"].get<size_t>(), plane["records"].get<size_t>()});
  const std::vector<BlockPlace> places = blocks_of(planes);
  ASSERT_GT(byte_count(planes), uint64_t{1} << 30);
  const auto blocks_with = [&](const std::string& stored) {
    std::string blocks;
    for (const BlockPlace& place : places) {
      BlockHeader header{place.plane, static_cast<uint32_t>(place.bytes), static_cast<uint32_t>(stored.size()), 0};
      header.checksum = block_checksum(header, std::as_bytes(std::span(stored)));
      blocks += bytes_of(header) + stored;
    }
    return blocks;
  };
  EXPECT_TRUE(has_words(message(json.dump(), blocks_with("")), "is cut off"));
  EXPECT_TRUE(has_words(message(json.dump(), blocks_with(std::string(37, 'x'))),
                        "is damaged: its header claims a stored size of 37 bytes"));
  // As many bytes as the smallest frame has, all wrong: the sums do not fit into 256 MiB, which is
  // reported.
  const std::string junk = blocks_with(std::string(38, 'x'));
  EXPECT_LT(junk.size(), size_t{1} << 17);
  set_contents(path_, file_of(json.dump(), junk));
  EXPECT_TRUE(has_words(check_accumulation(path_).error().message, "block 0 (of plane "));
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  const LittleMemory little(size_t{256} << 20);
  EXPECT_EQ(read_accumulation(path_).error().message, path_.string() + ": cannot read: no memory for its sums");
#endif
}

TEST_F(CraftedAccumulation, AcceptsSmallestFrames) {
  for (const size_t bytes : {size_t{16}, size_t{4096}, size_t{1} << 17, (size_t{1} << 17) + 16, kBlockBytes}) {
    const std::vector<std::byte> zeros(bytes);
    EXPECT_GE(store_block(zeros, 16).size(), min_stored_size(bytes)) << bytes;
  }
  EXPECT_LE(store_block(std::vector<std::byte>(kBlockBytes), 16).size(), 2 * min_stored_size(kBlockBytes));
}

TEST_F(CraftedAccumulation, BoundsMemoryOfSpans) {
  // So many blocks in a row that have every second sample of twice as many.
  const auto run_of = [](size_t blocks, uint32_t spans) {
    Json run = {blocks, 0};
    for (uint32_t i = 0; i < spans; ++i) {
      run.push_back(2 * i);
      run.push_back(2 * i + 1);
    }
    return Json::array({run});
  };
  Json json = json_;
  json["coverage"]["runs"] = run_of(4 * 3, 10000);
  EXPECT_EQ(message(json), "");
  EXPECT_EQ(read_accumulation_summary(path_).value().coverage[11].spans.size(), 10000U);
  // 16 million blocks: accepted as long as they take less than the sums, which the file has not
  // either; and 13 TB of them.
  json = of_size(V2i(1 << 15, 1 << 15));
  json["coverage"]["runs"] = run_of(1 << 24, 1000);
  EXPECT_TRUE(has_words(message(json), "is cut off"));
  json["coverage"]["runs"] = run_of(1 << 24, 100000);
  EXPECT_TRUE(has_words(message(json), "its header is invalid: 'runs' have more than "));
}

TEST_F(CraftedAccumulation, WritersObeyBoundsOfReaders) {
  // 2^21 spans of 8 bytes in each of 12 blocks: 192 MiB, beside sums of half a megabyte.
  RenderState state = random_state(kSmall, kSmallArea, false, 1);
  BlockCoverage many;
  Coverage coverage(kSmallArea);
  for (uint32_t i = 0; i < (1U << 20); ++i) ASSERT_TRUE(coverage.add(0, {3 * i, 3 * i + 1}));
  for (size_t block = 1; block < coverage.block_count(); ++block)
    for (const SampleRange& span : coverage[0].spans) ASSERT_TRUE(coverage.add(block, span));
  state.coverage = coverage;
  const Result<void> written = write_accumulation(path_, identity_of(kSmall, kSmallArea), state, true);
  ASSERT_FALSE(written.ok());
  EXPECT_TRUE(
      has_words(written.error().message, "cannot write: its samples are in too many pieces: 100663296 bytes of spans"));
  expect_small(path_, 1);
}

TEST_F(CraftedAccumulation, RefusesDeepJson) {
  const std::string deep(size_t{4} << 20, '[');
  EXPECT_TRUE(has_words(message(deep, blocks_), "its header is invalid: it has more than 64 levels"));
  EXPECT_TRUE(has_words(message(deep + std::string(deep.size(), ']'), blocks_), "its header is invalid: "));
  for (const char* key : {"image", "metadata"}) {
    Json json = json_;
    json[key] = R"({"a":)" + deep + std::string(deep.size(), ']') + "}";
    EXPECT_TRUE(has_words(message(json), "' is not JSON of at most 64 levels"));
    json[key] =
        R"({"a":"\"[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[[["})"; // brackets within a text do not nest
    EXPECT_EQ(message(json), "");
  }
}

TEST_F(CraftedAccumulation, BoundsMemoryOfLongLists) {
  const auto many = [](const char* member, size_t count) {
    std::string list = "[";
    for (size_t i = 0; i < count; ++i) list += std::string(i == 0 ? "" : ",") + member;
    return list + "]";
  };
  for (const char* key : {"/aovs", "/coverage/runs", "/part", "/size", "/crop", "/planes"})
    for (const char* member : {"1", "[]", "\"beauty\""}) {
      Json json = json_;
      json[Json::json_pointer(key)] = "@";
      std::string text = json.dump();
      text.replace(text.find("\"@\""), 3, many(member, 200000));
      const std::string printed = message(text, blocks_);
      EXPECT_EQ(printed.find("no memory"), std::string::npos) << key << ": " << printed;
      EXPECT_FALSE(printed.empty()) << key << " of " << member;
    }
}

// Replaces each number, text and list of the header by extreme values.
TEST_F(CraftedAccumulation, SurvivesExtremeMembers) {
  constexpr uint64_t kMax = std::numeric_limits<uint64_t>::max();
  const std::vector<Json> extremes{0,
                                   1,
                                   7,
                                   -1,
                                   1 << 20,
                                   (1 << 20) + 1,
                                   2147483648U,
                                   4294967295U,
                                   uint64_t{1} << 34,
                                   kMax,
                                   kMax / 2 + 1,
                                   0.5,
                                   1e308,
                                   -1e308,
                                   "",
                                   "\xc3\xa9",
                                   nullptr,
                                   true,
                                   false,
                                   Json::array(),
                                   Json::object(),
                                   Json::array({kMax, 1, kMax, kMax})};
  size_t good = 0, bad = 0;
  const Json flat = json_.flatten();
  for (const auto& [pointer, value] : flat.items())
    for (const Json& extreme : extremes) {
      Json json = json_;
      json[Json::json_pointer(pointer)] = extreme;
      const std::string printed = message(json);
      EXPECT_EQ(printed.find("no memory"), std::string::npos) << pointer << " = " << extreme << ": " << printed;
      (printed.empty() ? good : bad) += 1;
    }
  EXPECT_GT(good, 100U); // times, counts of rays and arguments may have any value
  EXPECT_GT(bad, 1000U);
}

TEST_F(CraftedAccumulation, RefusesWrongHeaderLength) {
  std::string file = contents(path_);
  for (const uint32_t length : {0U, 1U, 0x7fffffffU, 0xffffffffU}) {
    std::memcpy(file.data() + offsetof(FileHead, json_bytes), &length, sizeof length);
    set_contents(path_, file);
    const LittleMemory little(size_t{64} << 20);
    const Result<AccumulationSummary> read = read_accumulation_summary(path_);
    ASSERT_FALSE(read.ok());
    EXPECT_EQ(read.error().message.find("no memory"), std::string::npos) << read.error().message;
  }
}

// 4.4 GB of zero sums, stored uncompressed. Most of the file is a hole, so it takes 150 MB of disk.
TEST_F(CraftedAccumulation, ReadsFilesBeyondFourGiB) {
  constexpr size_t kPiece = size_t{1} << 17; // of a block of Zstandard
  const V2i size(8192, 7400);
  AccumulationHeader header;
  header.summary.identity = identity_of(size, {V2i(0), size});
  header.summary.coverage = Coverage({V2i(0), size});
  const std::string json = header_to_json(header);
  const std::vector<StoredPlane> planes = planes_of(header, {V2i(0), size});
  const std::vector<BlockPlace> places = blocks_of(planes);
  // A frame of so many zeros: where it is not zero, and how long it is.
  struct Stored {
    std::vector<std::pair<size_t, std::string>> pieces;
    uint32_t bytes = 0;
    uint32_t checksum = 0; // of the block
  };
  const auto store = [&](const BlockPlace& place) {
    std::string frame("\x28\xb5\x2f\xfd\xa0", 5); // its size in four bytes, one segment
    frame += bytes_of(static_cast<uint32_t>(place.bytes));
    Stored stored;
    stored.pieces.emplace_back(0, frame);
    for (size_t at = 0; at < place.bytes; at += kPiece) {
      const size_t piece = std::min(kPiece, place.bytes - at);
      const auto block = static_cast<uint32_t>(piece << 3 | (at + piece == place.bytes ? 1 : 0)); // raw
      stored.pieces.emplace_back(frame.size(), bytes_of(block).substr(0, 3));
      frame += bytes_of(block).substr(0, 3) + std::string(piece, '\0');
    }
    BlockHeader head{place.plane, static_cast<uint32_t>(place.bytes), static_cast<uint32_t>(frame.size()), 0};
    stored.bytes = head.stored_bytes;
    stored.checksum = block_checksum(head, std::as_bytes(std::span(frame)));
    return stored;
  };

  const int file = open(path_.c_str(), O_RDWR | O_TRUNC | O_CLOEXEC);
  ASSERT_GE(file, 0);
  const auto put = [&](uint64_t at, std::string_view bytes) {
    ASSERT_EQ(pwrite(file, bytes.data(), bytes.size(), static_cast<off_t>(at)), static_cast<ssize_t>(bytes.size()));
  };
  const std::string beginning = file_of(json, "");
  put(0, std::string_view(beginning).substr(0, sizeof(FileHead) + json.size()));
  uint64_t at = sizeof(FileHead) + json.size();
  FileTail tail;
  uint32_t all = 0;
  uint64_t last_block = 0;
  std::map<std::pair<uint32_t, size_t>, Stored> kinds;
  for (const BlockPlace& place : places) {
    const std::pair<uint32_t, size_t> kind(place.plane, place.bytes);
    auto found = kinds.find(kind);
    if (found == kinds.end()) found = kinds.emplace(kind, store(place)).first;
    const Stored& stored = found->second;
    last_block = at;
    put(at, bytes_of(BlockHeader{place.plane, static_cast<uint32_t>(place.bytes), stored.bytes, stored.checksum}));
    at += sizeof(BlockHeader);
    for (const auto& [offset, bytes] : stored.pieces) put(at + offset, bytes);
    at += stored.bytes;
    all = checksum_of(bytes_of(stored.checksum), all);
  }
  tail.file_bytes = at + sizeof tail;
  tail.blocks = static_cast<uint32_t>(places.size());
  tail.checksum = checksum_of(bytes_of(tail).substr(0, offsetof(FileTail, checksum)), all);
  put(at, bytes_of(tail));
  ASSERT_GT(tail.file_bytes, uint64_t{1} << 32);

  const LittleMemory little(size_t{1} << 30); // the sums are not kept
  const Result<AccumulationSummary> summary = read_accumulation_summary(path_);
  ASSERT_TRUE(summary.ok()) << summary.error().message;
  EXPECT_EQ(summary.value().sum_bytes, byte_count(planes));
  EXPECT_GT(summary.value().sum_bytes, uint64_t{1} << 32);
  const Result<void> checked = check_accumulation(path_);
  EXPECT_TRUE(checked.ok()) << checked.error().message;
  put(last_block + 1000, "x"); // the last one
  const Result<void> damaged = check_accumulation(path_);
  ASSERT_FALSE(damaged.ok());
  EXPECT_TRUE(has_words(damaged.error().message,
                        "at byte " + std::to_string(last_block) + ") is damaged: the checksum is wrong"));
  EXPECT_GT(last_block, uint64_t{1} << 32);
  close(file);
}

} // namespace
} // namespace kindling::test
