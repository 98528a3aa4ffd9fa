// Adds up the sums of the parts of an image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/merge_accumulations.h"

#include "renderer/session/render_identity.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <optional>

namespace kindling {

namespace {

Error damaged(const std::filesystem::path& file, const std::string& what) {
  return {ErrorKind::input_output, file.string() + ": " + what};
}

// Returns a hash of all sums of a film. Different sums collide with a probability of 2^-64.
uint64_t fingerprint(const Film& film) {
  uint64_t hash = 0x9E3779B97F4A7C15ULL;
  const auto take = [&hash](uint64_t word) {
    hash = (hash ^ word) * 0xD6E8FEB86659FD93ULL;
    hash ^= hash >> 32;
  };
  const auto take_all = [&take](std::span<const std::byte> bytes) {
    size_t at = 0;
    for (uint64_t word = 0; at + sizeof word <= bytes.size(); at += sizeof word) {
      std::memcpy(&word, bytes.data() + at, sizeof word);
      take(word);
    }
    for (; at < bytes.size(); ++at) take(static_cast<uint64_t>(bytes[at]));
    take(bytes.size());
  };
  for (const Film::ConstPlane& plane : film.planes()) take_all(plane.bytes);
  if (film.mattes().empty()) return hash;
  const FlatMattes mattes = film.mattes().flat();
  take_all(std::as_bytes(std::span(mattes.counts)));
  take_all(std::as_bytes(std::span(mattes.terms)));
  return hash;
}

bool same_rect(const PixelRect& a, const PixelRect& b) { return a.min == b.min && a.max == b.max; }

// Returns the rendered pixels of an image's crop; adaptive sampling extends it to whole blocks.
PixelRect area_of(const AccumulationIdentity& identity, bool adaptive) {
  return adaptive ? AdaptiveSampling::whole_blocks(identity.crop, identity.size_px) : identity.crop;
}

bool is_adaptive(const RenderState& state) { return !state.adaptive.stop_at.empty(); }

// Copies the state of adaptive sampling for the blocks of `part`, which no other part has.
void add_adaptive(const RenderState& part, RenderState& whole) {
  for (size_t i = 0; i < part.coverage.block_count(); ++i) {
    const PixelRect block = part.coverage.block(i);
    const size_t at = whole.coverage.index_of(block.min);
    whole.adaptive.stop_at[at] = part.adaptive.stop_at[i];
    whole.adaptive.rays[at] = part.adaptive.rays[i];
  }
  const PixelRect& from = part.coverage.area();
  const PixelRect& to = whole.coverage.area();
  for (int y = from.min.y; y < from.max.y; ++y) {
    const auto row = part.adaptive.earlier.begin() + static_cast<ptrdiff_t>(y - from.min.y) * from.width();
    std::copy(row, row + from.width(),
              whole.adaptive.earlier.begin() + static_cast<ptrdiff_t>(y - to.min.y) * to.width() +
                  (from.min.x - to.min.x));
  }
}

// The sum of the parts added so far.
class Sum {
 public:
  explicit Sum(const AccumulationIdentity& identity) : identity_(identity) {}

  Result<void> add(const std::filesystem::path& file, RenderState part) {
    if (!whole_) {
      const PixelRect area = area_of(identity_, is_adaptive(part));
      if (same_rect(part.film.crop(), area)) { // it has all pixels and becomes the sum itself
        whole_ = std::move(part);
        return {};
      }
      start(area, part);
    }
    if (Result<void> checked = check(file, part); !checked.ok()) return checked;
    for (size_t i = 0; i < part.coverage.block_count(); ++i) {
      const size_t at = whole_->coverage.index_of(part.coverage.block(i).min);
      for (const SampleRange& span : part.coverage[i].spans)
        if (!whole_->coverage.add(at, span))
          return damaged(file, "was changed during the merge: another file has some of its samples, too");
      if (part.coverage[i].stopped) whole_->coverage.set_stopped(at);
    }
    if (is_adaptive(part)) add_adaptive(part, *whole_);
    whole_->film.add(part.film);
    whole_->work.render_s += part.work.render_s;
    whole_->work.thread_s += part.work.thread_s;
    whole_->work.rays.add(part.work.rays);
    whole_->work.runs += part.work.runs;
    return {};
  }

  [[nodiscard]] RenderState take() { return *std::move(whole_); }

 private:
  void start(const PixelRect& area, const RenderState& part) {
    whole_.emplace(RenderState{Film(identity_.size_px, area, part.film.aovs()), Coverage(area), {}, {}});
    if (part.film.trims_outliers()) whole_->film.trim_outliers();
    if (part.film.has_splats()) whole_->film.enable_splats();
    whole_->work.light_paths = part.work.light_paths;
    whole_->work.photons = part.work.photons;
    whole_->work.direct_samples = part.work.direct_samples;
    whole_->work.reflection_samples = part.work.reflection_samples;
    whole_->work.path_reuse = part.work.path_reuse;
    whole_->work.rate_rule = part.work.rate_rule;
    whole_->film.split_by_light_groups(part.film.light_groups());
    if (!is_adaptive(part)) return;
    whole_->adaptive.stop_at.assign(whole_->coverage.block_count(), std::numeric_limits<uint32_t>::max());
    whole_->adaptive.rays.assign(whole_->coverage.block_count(), 0);
    whole_->adaptive.earlier.assign(static_cast<size_t>(area.pixel_count()), Film::Totals{});
  }

  // Checks what summaries do not show: layers, and the grid of blocks.
  [[nodiscard]] Result<void> check(const std::filesystem::path& file, const RenderState& part) const {
    if (part.work.light_paths != whole_->work.light_paths || part.film.has_splats() != whole_->film.has_splats())
      return damaged(file, "has other light paths than the first part: --light-paths auto traces none on devices; "
                           "render all parts on the CPU, or with --light-paths 0");
    if (part.work.photons != whole_->work.photons)
      return damaged(file, "has another number of photons than the first part (--photons auto)");
    if (part.work.direct_samples != whole_->work.direct_samples)
      return damaged(file, "has another number of light samples than the first part (--direct-samples auto)");
    if (part.work.reflection_samples != whole_->work.reflection_samples)
      return damaged(file, "has another number of reflection samples than the first part (--reflection-samples auto)");
    if (part.work.path_reuse != whole_->work.path_reuse)
      return damaged(file, "shares paths between other numbers of pixels than the first part (--path-reuse auto)");
    if (part.work.rate_rule != whole_->work.rate_rule)
      return damaged(file, "divides samples among pixels by another rule than the first part (--sample-rates auto)");
    if (part.film.aovs().bits() != whole_->film.aovs().bits() ||
        part.film.trims_outliers() != whole_->film.trims_outliers() ||
        !same_rect(part.film.splat_area(), whole_->film.splat_area()) ||
        part.film.light_groups() != whole_->film.light_groups())
      return damaged(file, "has different layers than the first part, although its settings are the same");
    if (is_adaptive(part) != is_adaptive(*whole_))
      return damaged(file, "differs from the first part in adaptive sampling, although its settings are the same");
    for (size_t i = 0; i < part.coverage.block_count(); ++i) {
      const PixelRect block = part.coverage.block(i);
      if (!same_rect(block, whole_->coverage.block(whole_->coverage.index_of(block.min))))
        return damaged(file, "does not consist of whole blocks of the image");
    }
    return {};
  }

  const AccumulationIdentity& identity_;
  std::optional<RenderState> whole_;
};

} // namespace

Result<Accumulation> merge_accumulations(const MergePlan& plan, const CancelToken* cancel,
                                         const std::function<void(size_t)>& files_done) {
  Sum sum(plan.identity);
  size_t done = 0;
  const auto read = [&](const std::filesystem::path& file) -> Result<RenderState> {
    if (cancel && cancel->cancelled()) return Error{ErrorKind::render_failed, "the merge was interrupted"};
    Result<Accumulation> part = read_accumulation(file);
    if (!part.ok()) return part.error();
    if (!image_differences(plan.identity, part.value().identity).empty())
      return damaged(file, "was changed during the merge: it belongs to another image now");
    return std::move(part).value().state;
  };
  const auto file_done = [&] {
    ++done;
    if (files_done) files_done(done);
  };
  for (size_t i = 0; i < plan.parts.size(); ++i) {
    Result<RenderState> part = read(plan.parts[i]);
    if (!part.ok()) return part.error();
    // Duplicates are compared before the part is moved into the sum.
    std::optional<uint64_t> own;
    for (const DuplicatePart& duplicate : plan.duplicates) {
      if (duplicate.same_as != i) continue;
      if (!own) own = fingerprint(part.value().film);
      const Result<RenderState> other = read(duplicate.file);
      if (!other.ok()) return other.error();
      if (fingerprint(other.value().film) != *own)
        return damaged(duplicate.file, "has the samples of " + plan.parts[i].string() +
                                           " but different sums: one of the two is wrong, from a faulty machine or "
                                           "an altered file; render that part again");
      file_done();
    }
    if (Result<void> added = sum.add(plan.parts[i], std::move(part).value()); !added.ok()) return added.error();
    file_done();
  }
  return Accumulation{plan.identity, sum.take()};
}

} // namespace kindling
