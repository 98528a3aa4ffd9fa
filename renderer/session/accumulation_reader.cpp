// Reads accumulation files; nothing in them is trusted before it is checked.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/accumulation_file.h"
#include "renderer/session/accumulation_header.h"
#include "renderer/session/accumulation_layout.h"
#include "renderer/session/stored_block.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cerrno>
#include <cstring>
#include <new>
#include <optional>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace kindling {
namespace {

namespace fs = std::filesystem;

constexpr size_t kBlocksReadAtOnce = 64;          // read, then decompressed together
static_assert(sizeof(off_t) == sizeof(uint64_t)); // files beyond 4 GiB need no other calls

class AccumulationReader {
 public:
  explicit AccumulationReader(const fs::path& path) : path_(path) {}
  AccumulationReader(const AccumulationReader&) = delete;
  AccumulationReader& operator=(const AccumulationReader&) = delete;
  ~AccumulationReader() {
    if (fd_ >= 0) close(fd_);
  }

  [[nodiscard]] Error error(std::string_view what) const {
    return Error{ErrorKind::input_output, fmt::format("{}: {}", path_.string(), what)};
  }
  [[nodiscard]] Error system_error() const { return error(fmt::format("cannot read: {}", std::strerror(errno))); }

  // Reads everything but the contents of blocks: head, JSON, positions and sizes of blocks, tail.
  [[nodiscard]] Result<void> open();
  [[nodiscard]] const ParsedHeader& parsed() const { return parsed_; }
  // Decompresses into planes with the sizes of parsed().planes. Without planes, only checks that
  // all can be read.
  [[nodiscard]] Result<void> read_blocks(std::span<const std::span<std::byte>> planes) const;

 private:
  struct Block {
    BlockPlace place;
    BlockHeader header;
    uint64_t offset = 0; // of the header in the file
  };

  [[nodiscard]] Result<void> read_at(uint64_t offset, std::span<std::byte> bytes) const;
  template <typename Record>
  [[nodiscard]] Result<void> read_record(uint64_t offset, Record& record) const {
    return read_at(offset, std::as_writable_bytes(std::span(&record, 1)));
  }
  [[nodiscard]] Result<uint64_t> read_header(); // returns the offset of the first block
  [[nodiscard]] Result<void> find_blocks(uint64_t offset);
  [[nodiscard]] Error damaged(const Block& block, std::string_view what) const {
    return error(fmt::format("block {} (of plane '{}', at byte {}) is damaged: {}", &block - blocks_.data(),
                             parsed_.planes[block.place.plane].name, block.offset, what));
  }

  fs::path path_;
  int fd_ = -1;
  uint64_t size_ = 0;
  ParsedHeader parsed_;
  std::vector<Block> blocks_;
};

Result<void> AccumulationReader::read_at(uint64_t offset, std::span<std::byte> bytes) const {
  if (offset > size_ || size_ - offset < bytes.size())
    return error(fmt::format("is cut off: it ends at byte {}, and {} bytes should stand at byte {}", size_,
                             bytes.size(), offset));
  while (!bytes.empty()) {
    const ssize_t count = pread(fd_, bytes.data(), bytes.size(), static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return system_error();
    if (count == 0) return error(fmt::format("became shorter while it was read: nothing is at byte {}", offset));
    bytes = bytes.subspan(static_cast<size_t>(count));
    offset += static_cast<uint64_t>(count);
  }
  return {};
}

Result<void> AccumulationReader::open() {
  // O_NONBLOCK: do not wait if it is a pipe.
  fd_ = ::open(path_.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat status {};
  if (fd_ < 0 || fstat(fd_, &status) != 0) return system_error();
  if (!S_ISREG(status.st_mode)) return error("is not a regular file");
  size_ = static_cast<uint64_t>(status.st_size);
  const Result<uint64_t> blocks = read_header();
  return blocks ? find_blocks(blocks.value()) : Result<void>(blocks.error());
}

Result<uint64_t> AccumulationReader::read_header() {
  FileHead head;
  if (size_ < sizeof head) return error("is not an accumulation file: it is too short");
  if (const Result<void> read = read_record(0, head); !read) return read.error();
  if (head.magic != kAccumulationMagic) return error("is not an accumulation file: it does not begin with KNDLACCU");
  if (head.version != kAccumulationVersion)
    return error(fmt::format("is an accumulation file of version {}; this program reads version {}", head.version,
                             kAccumulationVersion));
  if (head.json_bytes > size_ - sizeof head)
    return error(fmt::format("is cut off or damaged: {} bytes of header should stand at byte {}, it ends at byte {}",
                             head.json_bytes, sizeof head, size_));
  std::string json(head.json_bytes, '\0');
  if (const Result<void> read = read_at(sizeof head, std::as_writable_bytes(std::span(json))); !read)
    return read.error();
  const uint32_t before = checksum(std::as_bytes(std::span(&head, 1)).first(offsetof(FileHead, checksum)));
  if (checksum(std::as_bytes(std::span(json)), before) != head.checksum)
    return error(
        fmt::format("its header (bytes 0 to {}) is damaged: the checksum is wrong", sizeof head + json.size()));
  Result<ParsedHeader> parsed = header_from_json(json);
  if (!parsed) return error(fmt::format("its header is invalid: {}", parsed.error().message));
  parsed_ = std::move(parsed).value();
  return uint64_t{sizeof head + json.size()};
}

Result<void> AccumulationReader::find_blocks(uint64_t offset) {
  // The file must have room for all blocks before their list is allocated.
  const uint64_t bytes = parsed_.header.summary.sum_bytes;
  if (bytes / kBlockBytes > size_ / (sizeof(BlockHeader) + min_stored_size(kBlockBytes)))
    return error(fmt::format("is cut off: it ends at byte {}, too short for {} bytes of sums", size_, bytes));
  uint32_t all_checksums = 0;
  for (const BlockPlace& place : blocks_of(parsed_.planes)) {
    Block& block = blocks_.emplace_back();
    block.place = place;
    block.offset = offset;
    if (const Result<void> read = read_record(offset, block.header); !read) return read.error();
    if (block.header.plane != place.plane || block.header.bytes != place.bytes)
      return damaged(block,
                     fmt::format("its header claims {} bytes of plane {}", block.header.bytes, block.header.plane));
    if (block.header.stored_bytes > max_stored_size(place.bytes) ||
        block.header.stored_bytes < min_stored_size(place.bytes))
      return damaged(block, fmt::format("its header claims a stored size of {} bytes", block.header.stored_bytes));
    all_checksums = checksum(std::as_bytes(std::span(&block.header.checksum, 1)), all_checksums);
    offset += sizeof block.header + block.header.stored_bytes;
  }
  FileTail tail;
  if (const Result<void> read = read_record(offset, tail); !read) return read.error();
  const uint32_t expected =
      checksum(std::as_bytes(std::span(&tail, 1)).first(offsetof(FileTail, checksum)), all_checksums);
  if (tail.magic != kAccumulationEnd || tail.checksum != expected || tail.blocks != blocks_.size() ||
      tail.file_bytes != offset + sizeof tail)
    return error(fmt::format("its end (24 bytes at byte {}) is damaged or not written", offset));
  if (size_ != tail.file_bytes)
    return error(
        fmt::format("is damaged: it has {} bytes after its end at byte {}", size_ - tail.file_bytes, tail.file_bytes));
  return {};
}

Result<void> AccumulationReader::read_blocks(std::span<const std::span<std::byte>> planes) const {
  std::vector<std::vector<std::byte>> stored(std::min(blocks_.size(), kBlocksReadAtOnce));
  std::vector<std::vector<std::byte>> unwanted(planes.empty() ? stored.size() : 0);
  std::vector<std::string_view> faults(stored.size());
  for (size_t first = 0; first < blocks_.size(); first += kBlocksReadAtOnce) {
    const size_t count = std::min(blocks_.size() - first, kBlocksReadAtOnce);
    for (size_t i = 0; i < count; ++i) {
      const Block& block = blocks_[first + i];
      stored[i].resize(block.header.stored_bytes);
      if (const Result<void> read = read_at(block.offset + sizeof block.header, stored[i]); !read) return read.error();
    }
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 1), [&](const tbb::blocked_range<size_t>& range) {
      for (size_t i = range.begin(); i != range.end(); ++i) {
        const auto& [place, header, offset] = blocks_[first + i];
        if (planes.empty()) unwanted[i].resize(place.bytes);
        const std::span<std::byte> records =
            planes.empty() ? std::span(unwanted[i]) : planes[place.plane].subspan(place.first_byte, place.bytes);
        faults[i] = block_checksum(header, stored[i]) != header.checksum
                        ? "the checksum is wrong"
                        : restore_block(stored[i], parsed_.planes[place.plane].record_bytes, records);
      }
    });
    for (size_t i = 0; i < count; ++i)
      if (!faults[i].empty()) return damaged(blocks_[first + i], faults[i]);
  }
  return {};
}

Result<Accumulation> read(const fs::path& path) {
  AccumulationReader reader(path);
  if (const Result<void> opened = reader.open(); !opened) return opened.error();
  const ParsedHeader& parsed = reader.parsed();
  const AccumulationSummary& summary = parsed.header.summary;
  RenderState state{
      Film(summary.identity.size_px, parsed.area, parsed.header.aovs), coverage_of(parsed), {}, summary.work};
  if (parsed.header.trims_outliers) state.film.trim_outliers();
  if (parsed.header.splat_area) state.film.enable_splats(*parsed.header.splat_area);
  state.film.split_by_light_groups(parsed.header.light_groups);
  if (parsed.header.adaptive) {
    state.adaptive.stop_at.resize(state.coverage.block_count());
    state.adaptive.rays.resize(state.coverage.block_count());
    state.adaptive.earlier.resize(static_cast<size_t>(parsed.area.pixel_count()));
  }
  FlatMattes mattes;
  if (parsed.header.aovs.has_mattes()) {
    mattes.counts.resize(static_cast<size_t>(parsed.area.pixel_count()));
    mattes.terms.resize(parsed.header.matte_terms);
  }
  if (const Result<void> filled = reader.read_blocks(plane_bytes<std::byte>(state, mattes)); !filled)
    return filled.error();
  state.film.mattes().set(mattes);
  return Accumulation{summary.identity, std::move(state)};
}

Error no_memory(const fs::path& path) {
  return Error{ErrorKind::input_output, fmt::format("{}: cannot read: no memory for its sums", path.string())};
}

} // namespace

Result<Accumulation> read_accumulation(const fs::path& path) {
  try {
    return read(path);
  } catch (const std::bad_alloc&) {
    return no_memory(path);
  }
}

Result<void> check_accumulation(const fs::path& path) {
  try {
    AccumulationReader reader(path);
    if (Result<void> opened = reader.open(); !opened) return opened;
    return reader.read_blocks({});
  } catch (const std::bad_alloc&) {
    return no_memory(path);
  }
}

Result<AccumulationSummary> read_accumulation_summary(const fs::path& path) {
  try {
    AccumulationReader reader(path);
    if (const Result<void> opened = reader.open(); !opened) return opened.error();
    AccumulationSummary summary = reader.parsed().header.summary;
    summary.coverage = coverage_of(reader.parsed());
    return summary;
  } catch (const std::bad_alloc&) {
    return no_memory(path);
  }
}

} // namespace kindling
