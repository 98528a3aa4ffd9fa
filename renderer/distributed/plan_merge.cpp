// Planning of a merge: checks that files belong to one image, finds overlaps, duplicates and gaps.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/merge_accumulations.h"
#include "renderer/distributed/work_parts.h"
#include "renderer/session/adaptive_sampling.h"
#include "renderer/session/render_identity.h"

#include <algorithm>
#include <set>
#include <tuple>

namespace kindling {

namespace {

namespace fs = std::filesystem;

bool inside(const PixelRect& inner, const PixelRect& outer) {
  return inner.min.x >= outer.min.x && inner.min.y >= outer.min.y && inner.max.x <= outer.max.x &&
         inner.max.y <= outer.max.y;
}

// A run-length encoded coverage, since thousands of parts are held at once.
struct CompactCoverage {
  struct Run {
    size_t count = 0;
    BlockCoverage block;
    bool operator==(const Run&) const = default;
  };
  PixelRect area;
  std::vector<Run> runs;

  explicit CompactCoverage(const Coverage& coverage) : area(coverage.area()) {
    for (size_t i = 0; i < coverage.block_count(); ++i) {
      if (runs.empty() || runs.back().block != coverage[i]) runs.push_back({0, coverage[i]});
      ++runs.back().count;
    }
  }
  bool operator==(const CompactCoverage& other) const {
    return area.min == other.area.min && area.max == other.area.max && runs == other.runs;
  }
  [[nodiscard]] bool empty() const {
    return std::all_of(runs.begin(), runs.end(), [](const Run& run) { return run.block.spans.empty(); });
  }
  // Calls `visit(index, block)` for each block with samples, with its index in `whole`.
  template <typename Visit>
  void visit_blocks(const Coverage& whole, Visit visit) const {
    const Coverage own(area);
    size_t i = 0;
    for (const Run& run : runs)
      for (size_t end = i + run.count; i < end; ++i)
        if (!run.block.spans.empty() || run.block.stopped) visit(whole.index_of(own.block(i).min), run.block);
  }
};

struct File {
  fs::path path;
  AccumulationIdentity identity;
  CompactCoverage coverage;
};

std::string span_text(const SampleRange& span) {
  return std::to_string(span.first) + "-" + std::to_string(span.end - 1);
}

// The merged coverage of the files added so far.
class Whole {
 public:
  explicit Whole(const AccumulationIdentity& identity)
      : coverage_(AdaptiveSampling::whole_blocks(identity.crop, identity.size_px)) {}

  [[nodiscard]] const Coverage& coverage() const { return coverage_; }

  // Fails (usage) if a sample was added before, naming the file among `earlier` that has it.
  Result<void> add(const File& file, std::span<const File> earlier) {
    std::optional<Error> failure;
    file.coverage.visit_blocks(coverage_, [&](size_t index, const BlockCoverage& block) {
      for (const SampleRange& span : block.spans)
        if (!failure && !coverage_.add(index, span)) failure = overlap(file, index, span, earlier);
      if (block.stopped) coverage_.set_stopped(index);
    });
    if (failure) return *failure;
    return {};
  }

  // True if all samples of the file have been added.
  [[nodiscard]] bool has_all_of(const File& file) const {
    bool all = true;
    file.coverage.visit_blocks(coverage_, [&](size_t index, const BlockCoverage& block) {
      for (const SampleRange& span : block.spans) all = all && coverage_.done(index, span) == span.count();
    });
    return all;
  }

 private:
  [[nodiscard]] Error overlap(const File& file, size_t index, const SampleRange& span,
                              std::span<const File> earlier) const {
    for (const File& other : earlier) {
      std::optional<Error> found;
      other.coverage.visit_blocks(coverage_, [&](size_t at, const BlockCoverage& block) {
        if (at != index || found) return;
        for (const SampleRange& theirs : block.spans) {
          const SampleRange both{std::max(span.first, theirs.first), std::min(span.end, theirs.end)};
          if (both.empty()) continue;
          const PixelRect pixels = coverage_.block(index);
          found = usage_error(file.path.string() + " and " + other.path.string() + " overlap: both have samples " +
                              span_text(both) + " of pixel (" + std::to_string(pixels.min.x) + ", " +
                              std::to_string(pixels.min.y) + ") but not the same ones in all; leave one of them out");
          return;
        }
      });
      if (found) return *found;
    }
    return usage_error(file.path.string() + ": has samples " + span_text(span) + " twice");
  }

  Coverage coverage_;
};

bool same_file(const fs::path& a, const fs::path& b) {
  std::error_code error;
  return fs::equivalent(a, b, error) && !error;
}

// True for files that a render keeps beside NAME.kacc: its previous generation, or a damaged one
// that was put aside.
bool is_previous(const fs::path& path) { return path.extension() == ".previous" || path.extension() == ".damaged"; }

bool is_lock(const fs::path& path) { return path.extension() == ".lock"; }

// True for the temporary file of a process that was killed while writing. It is never complete.
bool is_unfinished(const fs::path& path) {
  return path.extension() == ".tmp" && path.filename().string().starts_with(".kindling-");
}

Result<File> read_file(const fs::path& path) {
  Result<AccumulationSummary> read = read_accumulation_summary(path);
  if (!read.ok()) return read.error();
  AccumulationSummary summary = std::move(read).value();
  if (!inside(summary.coverage.area(), AdaptiveSampling::whole_blocks(summary.identity.crop, summary.identity.size_px)))
    return Error{ErrorKind::input_output, path.string() + ": has pixels outside of its own image"};
  return File{path, std::move(summary.identity), CompactCoverage(summary.coverage)};
}

Error other_image(const File& file, const File& first, const std::vector<ImageDifference>& differences) {
  constexpr size_t kMaxNamed = 6;
  std::string text = file.path.string() + " belongs to another image than " + first.path.string() + ": ";
  for (size_t i = 0; i < std::min(differences.size(), kMaxNamed); ++i) {
    const auto& [what, here, there] = differences[i];
    text += (i > 0 ? "; " : "") + what + ": " + here + " and " + there;
  }
  if (differences.size() > kMaxNamed) text += "; and " + std::to_string(differences.size() - kMaxNamed) + " more";
  return usage_error(std::move(text));
}

// Returns the identity of the merged image: that of the first part, in an order independent of the
// files'.
AccumulationIdentity merged_identity(std::span<const File> parts) {
  const auto order = [](const File& file) {
    const AccumulationIdentity& identity = file.identity;
    const PixelRect& area = file.coverage.area;
    return std::tuple(~identity.samples_per_pixel, identity.part.first, identity.part.end, area.min.y, area.min.x,
                      identity.arguments);
  };
  const auto first =
      std::min_element(parts.begin(), parts.end(), [&](const File& a, const File& b) { return order(a) < order(b); });
  AccumulationIdentity identity = first->identity;
  identity.arguments = whole_image_arguments(identity.arguments);
  identity.part = {0, identity.samples_per_pixel};
  return identity;
}

// Returns the finest division that any part's arguments name.
PartCounts part_counts(std::span<const File> files) {
  PartCounts counts;
  for (const File& file : files) {
    const WorkPart part = part_of_arguments(file.identity.arguments);
    if (part.samples) counts.samples = std::max(counts.samples, part.samples->count);
    if (part.tiles) counts.tiles = std::max(counts.tiles, part.tiles->count);
  }
  return counts;
}

// Returns the files without those that are given twice, which are added to `left_out`.
std::vector<fs::path> without_repeats(std::span<const fs::path> files, std::vector<LeftOut>& left_out) {
  std::vector<fs::path> unique;
  std::set<std::string> seen; // with links resolved
  for (const fs::path& file : files) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(file, error);
    if (error || seen.insert(canonical.string()).second)
      unique.push_back(file);
    else
      left_out.push_back({file, "is given twice"});
  }
  return unique;
}

// Returns why a file is no part, as far as its name and the other files' names show it.
std::optional<std::string> reason_to_leave_out(const fs::path& path, std::span<const fs::path> files) {
  if (is_unfinished(path)) return "is the unfinished file of a process that was killed";
  if (is_lock(path)) return "is the lock of a checkpoint";
  const auto is_newer = [&](const fs::path& other) { return same_file(other, fs::path(path).replace_extension()); };
  if (is_previous(path) && std::any_of(files.begin(), files.end(), is_newer))
    return "is the previous generation of another given file";
  return std::nullopt;
}

} // namespace

Result<MergePlan> plan_merge(std::span<const fs::path> files, std::span<const fs::path> outputs) {
  if (files.empty()) return usage_error("no parts; use 'kindling merge PART.kacc... -o OUT'");
  MergePlan plan;
  const std::vector<fs::path> wanted = without_repeats(files, plan.left_out);
  std::vector<File> parts;
  std::vector<File> own_outputs; // of an earlier merge, most likely
  std::optional<File> first;
  for (const fs::path& path : wanted) {
    if (std::optional<std::string> reason = reason_to_leave_out(path, wanted)) {
      plan.left_out.push_back({path, *std::move(reason)});
      continue;
    }
    Result<File> read = read_file(path);
    if (!read.ok()) return read.error();
    File file = std::move(read).value();
    if (!first) first = file;
    if (const std::vector<ImageDifference> differences = image_differences(first->identity, file.identity);
        !differences.empty())
      return other_image(file, *first, differences);
    if (file.coverage.empty()) {
      plan.left_out.push_back({path, "has no samples yet"});
      continue;
    }
    if (std::any_of(outputs.begin(), outputs.end(), [&](const fs::path& output) { return same_file(output, path); })) {
      own_outputs.push_back(std::move(file));
      continue;
    }
    const auto same =
        std::find_if(parts.begin(), parts.end(), [&](const File& other) { return other.coverage == file.coverage; });
    if (same != parts.end())
      plan.duplicates.push_back({path, static_cast<size_t>(same - parts.begin())});
    else
      parts.push_back(std::move(file));
  }

  if (!first) return usage_error(files.front().string() + ": is not a part; there is nothing to merge");
  Whole whole(first->identity);
  for (size_t i = 0; i < parts.size(); ++i)
    if (Result<void> added = whole.add(parts[i], std::span(parts).first(i)); !added.ok()) return added.error();
  for (File& file : own_outputs) {
    if (whole.has_all_of(file)) {
      plan.left_out.push_back({file.path, "is an output, and the other files have all of its samples"});
      continue;
    }
    if (Result<void> added = whole.add(file, parts); !added.ok()) return added.error();
    parts.push_back(std::move(file));
  }
  if (parts.empty()) return usage_error(files.front().string() + ": has no samples yet; there is nothing to merge");
  plan.identity = merged_identity(parts);
  plan.gaps = find_gaps(whole.coverage(), plan.identity.crop, plan.identity.samples_per_pixel, part_counts(parts));
  for (File& file : parts) plan.parts.push_back(std::move(file.path));
  return plan;
}

} // namespace kindling
