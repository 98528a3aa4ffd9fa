// Harness: records of a farm, its plan, and what its engine and its renders print.
//
// The first byte chooses the reader; the others are the file or the text.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_engine.h"
#include "renderer/distributed/farm_plan.h"
#include "renderer/distributed/farm_records.h"
#include "renderer/distributed/farm_status.h"
#include "renderer/distributed/program_lines.h"
#include "renderer/distributed/slurm_engine.h"
#include "tests/fuzz/fuzz_support.h"
#include "tests/fuzz/mutators/custom_mutator.h"
#include "tests/fuzz/mutators/mutate_json.h"

#include <algorithm>
#include <string>

using namespace kindling;
using namespace kindling::fuzz;

namespace {

template <typename T>
void check(const Result<T>& result, const std::filesystem::path& named) {
  if (!result) require_good_message(result.error(), named.string());
}

void read_task(const InputFolder& folder, std::string_view text) {
  const auto file = folder.write("task.json", text);
  const Result<TaskRecord> record = read_task_record(file);
  check(record, file);
  if (!record) return;
  for (const int retries : {0, 2}) static_cast<void>(judge(record.value(), retries));
  require(write_task_record(folder.path() / "copy.json", record.value()).ok(), "a record that was read can be written");
}

void read_farm(const InputFolder& folder, std::string_view text) {
  folder.write("plan.json", text);
  const Result<FarmPlan> plan = read_plan(folder.path());
  check(plan, "plan.json");
  // A status takes two look-ups of files for each task.
  if (!plan || plan.value().task_count() > 100) return;
  static_cast<void>(farm_status(plan.value(), FarmQueue{}));
  const int last = plan.value().task_count() - 1;
  for (const int number : {0, last}) {
    const FarmTask task = plan.value().task(number);
    static_cast<void>(plan.value().unfinished_file(task));
    static_cast<void>(plan.value().checkpoint_file(task));
    static_cast<void>(plan.value().stats_file(task));
  }
  for (int index = 0; index < plan.value().frame_count(); ++index) static_cast<void>(plan.value().outputs_of(index));
  static_cast<void>(check_slurm_resources(plan.value().resources));
  static_cast<void>(slurm_merge_script(plan.value()));
  const int tasks[] = {0, last};
  static_cast<void>(slurm_array_script(plan.value(), std::span(tasks).first(last > 0 ? 2 : 1)));
}

void read_lines(std::string_view text) {
  const FarmLog silent = [](std::string_view) {};
  ProgramLines lines(silent);
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    static_cast<void>(lines.take(text.substr(0, end)));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
}

void read_slurm(std::string_view text) {
  const FarmJobs jobs{{{"12", {0, 1, 2}}, {"13", {7}}}, "14"};
  static_cast<void>(parse_squeue(text, jobs));
  static_cast<void>(parse_sbatch(text));
  static_cast<void>(parse_largest_array(text));
  const std::string word(text.substr(0, text.find('\n')));
  static_cast<void>(slurm_time_s(word));
  const FarmResources resources{word, 1, word, word};
  static_cast<void>(time_warning_s(resources));
  static_cast<void>(check_slurm_resources(resources));
}

} // namespace

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
  return mutate_in_place(data, size, max_size, seed, [](std::string_view input, size_t max, Random& random) {
    if (input.empty() || max < 2) return mutate_bytes(input, max);
    return input.front() + mutate_json(input.substr(1), max - 1, random);
  });
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const InputFolder folder;
  if (size < 1) return -1;
  const std::string_view text = input_text(data, size).substr(1);
  switch (data[0]) {
  case 'j': {
    folder.write("jobs.json", text);
    check(read_jobs(folder.path()), "jobs.json");
    break;
  }
  case 'l': read_lines(text); break;
  case 'm': {
    const auto file = folder.write("frame.json", text);
    check(read_merge_record(file), file);
    break;
  }
  case 'p': read_farm(folder, text); break;
  case 'r': {
    const auto file = folder.write("refused.json", text);
    check(read_refusal(file), file);
    break;
  }
  case 's': read_slurm(text); break;
  case 't': read_task(folder, text); break;
  default: return -1;
  }
  return 0;
}
