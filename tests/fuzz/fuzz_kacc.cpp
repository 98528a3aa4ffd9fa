// Harness: checkpoints and parts of renders (.kacc).
// SPDX-License-Identifier: Apache-2.0
#include "renderer/session/accumulation_file.h"
#include "tests/fuzz/fuzz_support.h"
#include "tests/fuzz/mutators/custom_mutator.h"
#include "tests/fuzz/mutators/mutate_accumulation.h"

#include <string>

using namespace kindling;
using namespace kindling::fuzz;

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  use_one_thread();
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
  return mutate_in_place(data, size, max_size, seed, mutate_accumulation);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const InputFolder folder;
  const std::filesystem::path file = folder.write("input.kacc", input_bytes(data, size));
  const Result<AccumulationSummary> summary = read_accumulation_summary(file);
  const Result<void> checked = check_accumulation(file);
  const Result<Accumulation> read = read_accumulation(file);
  require(read.ok() == checked.ok(), "a file that is read was found good, and the reverse");
  require(summary.ok() || !read.ok(), "a file that is read has a summary");
  if (!summary) require_good_message(summary.error(), file.string() + ": ");
  if (!checked) require_good_message(checked.error(), file.string() + ": ");
  if (!read) return 0;
  // Written again it must read as the same.
  const std::filesystem::path copy = folder.path() / "copy.kacc";
  const Result<void> written = write_accumulation(copy, read.value().identity, read.value().state, false);
  require(written.ok(), "a file that was read can be written");
  const Result<Accumulation> again = read_accumulation(copy);
  require(again.ok(), "a file that was written can be read");
  require(again.value().state.coverage == read.value().state.coverage, "it has the same coverage");
  require(again.value().identity.arguments == read.value().identity.arguments, "it has the same arguments");
  return 0;
}
