// Merges accumulation files: checks that they are parts of one image, and adds them up.
//
// Sums are exact (renderer/base/exact_sum.h), so neither the order nor the grouping of parts changes a bit: what has all samples is the
// image that one process would have rendered. README.md tells what is refused and why.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/distributed/gaps.h"
#include "renderer/session/accumulation_file.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace kindling {

// A file with the coverage of another: it must have the same sums as well, which is seen when it is read.
struct DuplicatePart {
  std::filesystem::path file;
  size_t same_as = 0; // index into MergePlan::parts
};

// A file that was given and is none of the parts.
struct LeftOut {
  std::filesystem::path file;
  std::string reason; // "is the output of an earlier merge"
};

struct MergePlan {
  AccumulationIdentity identity; // of the merged image: arguments without parts, the samples of all
  std::vector<std::filesystem::path> parts;
  std::vector<DuplicatePart> duplicates;
  std::vector<LeftOut> left_out;
  Gaps gaps;
};

// Reads what the files are about, not their sums. `outputs` are the names that the merge will write; one that is among the files counts
// as a part unless all that it has is in others.
//
// Fails (usage): no file; files of different images (with what differs), or of different programs; two files with the same samples of a
// pixel, unless they have the same samples everywhere. Fails (input_output): a file that cannot be read, is none of ours or is damaged.
// Gaps are no failure.
[[nodiscard]] Result<MergePlan> plan_merge(std::span<const std::filesystem::path> files,
                                           std::span<const std::filesystem::path> outputs);

// Adds up the parts of a plan; memory: the whole film and one part at a time, two where it has a duplicate. `files_done` is called after
// each file with how many of parts and duplicates are done; it may be null. Fails (input_output): a file is damaged, is not what it was
// when the plan was made, or has other sums than its duplicate. Fails (render_failed) when cancelled.
[[nodiscard]] Result<Accumulation> merge_accumulations(const MergePlan& plan, const CancelToken* cancel,
                                                       const std::function<void(size_t)>& files_done);

} // namespace kindling
