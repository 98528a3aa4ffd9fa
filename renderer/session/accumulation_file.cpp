// Writes accumulation files: header, compressed blocks, tail.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/accumulation_file.h"

#include "renderer/image/atomic_file.h"
#include "renderer/session/accumulation_header.h"
#include "renderer/session/accumulation_layout.h"
#include "renderer/session/stored_block.h"

#include <fmt/format.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <cassert>
#include <limits>
#include <new>

namespace kindling {
namespace {

namespace fs = std::filesystem;

constexpr size_t kBlocksAtOnce = 64; // compressed together, then written

Error cannot_write(const fs::path& path, std::string_view why) {
  return Error{ErrorKind::input_output, fmt::format("{}: cannot write: {}", path.string(), why)};
}

template <typename Record>
std::span<const std::byte> bytes_of(const Record& record) {
  return std::as_bytes(std::span(&record, 1));
}

Result<void> write(const fs::path& path, const AccumulationIdentity& identity, const RenderState& state,
                   bool keep_previous) {
  assert(state.film.size_px() == identity.size_px);
  assert(state.film.crop().min == state.coverage.area().min && state.film.crop().max == state.coverage.area().max);
  assert(state.adaptive.empty() || state.adaptive.fits(state.film.crop()));
  AccumulationHeader header;
  header.summary = {identity, state.coverage, state.work};
  header.aovs = state.film.aovs();
  header.trims_outliers = state.film.trims_outliers();
  if (state.film.has_splats()) header.splat_area = state.film.splat_area();
  header.light_groups = state.film.light_groups();
  header.adaptive = !state.adaptive.empty();
  const FlatMattes mattes = state.film.mattes().flat();
  header.matte_terms = mattes.terms.size();
  const std::vector<StoredPlane> planes = planes_of(header, state.film.crop());
  uint64_t span_bytes = 0;
  for (size_t i = 0; i < state.coverage.block_count(); ++i)
    span_bytes += state.coverage[i].spans.size() * sizeof(SampleRange);
  if (span_bytes > max_coverage_bytes(planes))
    return cannot_write(path, fmt::format("its samples are in too many pieces: {} bytes of spans, at most {}",
                                          span_bytes, max_coverage_bytes(planes)));
  const std::string json = header_to_json(header);
  if (json.size() > std::numeric_limits<uint32_t>::max()) return cannot_write(path, "its header is beyond 4 GiB");
  const std::vector<std::span<const std::byte>> planes_bytes = plane_bytes<const std::byte>(state, mattes);
  const std::vector<BlockPlace> blocks = blocks_of(planes);

  AtomicFile::remove_leftovers(path);
  Result<AtomicFile> created = AtomicFile::create(path);
  if (!created) return created.error();
  AtomicFile& file = created.value();
  uint64_t written = 0;
  const auto put = [&](std::span<const std::byte> bytes) {
    file.write(bytes.data(), bytes.size());
    written += bytes.size();
  };

  FileHead head;
  head.json_bytes = static_cast<uint32_t>(json.size());
  head.checksum =
      checksum(std::as_bytes(std::span(json)), checksum(bytes_of(head).first(offsetof(FileHead, checksum))));
  put(bytes_of(head));
  put(std::as_bytes(std::span(json)));

  FileTail tail;
  uint32_t all_checksums = 0;
  std::vector<std::vector<std::byte>> stored(std::min(blocks.size(), kBlocksAtOnce));
  for (size_t first = 0; first < blocks.size() && !file.failed(); first += kBlocksAtOnce) {
    const size_t count = std::min(blocks.size() - first, kBlocksAtOnce);
    tbb::parallel_for(tbb::blocked_range<size_t>(0, count, 1), [&](const tbb::blocked_range<size_t>& range) {
      for (size_t i = range.begin(); i != range.end(); ++i) {
        const BlockPlace& block = blocks[first + i];
        stored[i] = store_block(planes_bytes[block.plane].subspan(block.first_byte, block.bytes),
                                planes[block.plane].record_bytes);
      }
    });
    for (size_t i = 0; i < count; ++i) {
      if (stored[i].empty()) return cannot_write(path, "no memory to compress it");
      BlockHeader block{blocks[first + i].plane, static_cast<uint32_t>(blocks[first + i].bytes),
                        static_cast<uint32_t>(stored[i].size()), 0};
      block.checksum = block_checksum(block, stored[i]);
      all_checksums = checksum(bytes_of(block.checksum), all_checksums);
      put(bytes_of(block));
      put(stored[i]);
    }
  }
  tail.file_bytes = written + sizeof tail;
  tail.blocks = static_cast<uint32_t>(blocks.size());
  tail.checksum = checksum(bytes_of(tail).first(offsetof(FileTail, checksum)), all_checksums);
  put(bytes_of(tail));
  return file.commit(keep_previous ? previous_accumulation(path) : fs::path());
}

} // namespace

bool names_accumulation(const fs::path& file) {
  const fs::path extension = file.extension();
  return extension == kAccumulationExtension ||
         ((extension == ".previous" || extension == ".damaged") && file.stem().extension() == kAccumulationExtension);
}

fs::path previous_accumulation(const fs::path& path) { return end_of_links(path) += ".previous"; }

Result<void> write_accumulation(const fs::path& path, const AccumulationIdentity& identity, const RenderState& state,
                                bool keep_previous) {
  try {
    return write(path, identity, state, keep_previous);
  } catch (const std::bad_alloc&) {
    return cannot_write(path, "no memory to compress it");
  }
}

} // namespace kindling
