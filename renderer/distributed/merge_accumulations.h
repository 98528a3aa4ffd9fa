// Merging of accumulation files: checks that they are parts of one image, and adds up their sums.
//
// Sums are exact (renderer/base/exact_sum.h), so neither order nor grouping of the parts changes a
// bit: the merge of all parts is the image that one process would have rendered. README.md lists
// what is refused and why.
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

// A file with the same coverage as another. merge_accumulations() checks that its sums are the
// same, too.
struct DuplicatePart {
  std::filesystem::path file;
  size_t same_as = 0; // index into MergePlan::parts
};

// A given file that is not merged.
struct LeftOut {
  std::filesystem::path file;
  std::string reason; // "is given twice"
};

struct MergePlan {
  AccumulationIdentity identity; // of the merged image: arguments without parts, the samples of all
  std::vector<std::filesystem::path> parts;
  std::vector<DuplicatePart> duplicates;
  std::vector<LeftOut> left_out;
  Gaps gaps;
};

// Plans a merge from the files' headers and coverages, without their sums. `outputs` are the names
// that the merge will write; one that is among the files counts as a part unless all of its samples
// are in others.
//
// Fails (usage) for no files, for files of different images (listing the differences) or programs,
// and for two files with a sample of a pixel in common, unless all of their samples are the same.
// Fails (input_output) for files that cannot be read, are no accumulations or are damaged. Gaps are
// not a failure.
[[nodiscard]] Result<MergePlan> plan_merge(std::span<const std::filesystem::path> files,
                                           std::span<const std::filesystem::path> outputs);

// Adds up the parts of a plan. Takes memory for the whole film and one part, two for a part with a
// duplicate. `files_done` may be empty; it is called after each file with the number of parts and
// duplicates done. Fails (input_output) if a file is damaged, has changed since the plan was made,
// or differs from its duplicate. Fails (render_failed) when cancelled.
[[nodiscard]] Result<Accumulation> merge_accumulations(const MergePlan& plan, const CancelToken* cancel,
                                                       const std::function<void(size_t)>& files_done);

} // namespace kindling
