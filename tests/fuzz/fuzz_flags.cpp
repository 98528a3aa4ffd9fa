// Harness: the command line's words, one a line.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/parse_command_line.h"
#include "tests/fuzz/fuzz_support.h"
#include "tests/fuzz/mutators/custom_mutator.h"
#include "tests/fuzz/mutators/mutate_json.h"

#include <algorithm>
#include <cstdlib>
#include <string>
#include <vector>

#include <unistd.h>

using namespace kindling;
using namespace kindling::fuzz;

namespace {

std::vector<std::string> words_of(std::string_view text) {
  std::vector<std::string> words;
  while (!text.empty()) {
    const size_t end = std::min(text.find('\n'), text.size());
    words.emplace_back(text.substr(0, end).substr(0, text.substr(0, end).find('\0')));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return words;
}

std::string text_of(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text.append(text.empty() ? "" : "\n").append(word);
  return text;
}

// Commands, flags and their values, from the program's own tables, and values of many kinds.
const std::vector<std::string>& vocabulary() {
  static const std::vector<std::string> words = [] {
    std::vector<std::string> all = {
        "scene.glb", "part.kacc", "out.exr", "out.####.png", "0",    "1",    "-1",     "7",      "64",
        "0.5",       "1e30",      "nan",     "inf",          "1/4",  "4/4",  "0/0",    "1-10",   "1,2",
        "10-1:3",    "1,1,1",     "640x480", "0x0",          "auto", "none", "all",    "4G",     "1:00",
        "--",        "-o",        "",        "1920x1080",    "2:3",  "farm", "submit", "status", "retry",
        "work",      "merge",     "help",    "completion",   "bash", "zsh",  "manual"};
    for (const app::CommandTable& table : app::command_tables()) {
      all.push_back(table.name);
      for (const app::FlagRow& row : table.flags) {
        all.push_back(row.long_name);
        if (!row.short_name.empty()) all.push_back(row.short_name);
        for (std::string& choice : app::label_choices(row.label)) all.push_back(std::move(choice));
      }
    }
    return all;
  }();
  return words;
}

std::string mutate_words(std::string_view text, size_t max_size, Random& random) {
  if (random.one_in(8)) return mutate_bytes(text, max_size);
  std::vector<std::string> words = words_of(text);
  const auto other = [&] { return vocabulary()[random.below(vocabulary().size())]; };
  for (size_t i = 0, count = 1 + random.below(4); i < count; ++i) {
    if (words.empty()) words.push_back(other());
    const auto place = words.begin() + static_cast<std::ptrdiff_t>(random.below(words.size()));
    switch (random.below(6)) {
    case 0: words.erase(place); break;
    case 1:
    case 2: words.insert(place + 1, other()); break;
    case 3: *place = other(); break;
    case 4: place->append("=").append(other()); break;
    default: *place = mutate_bytes(*place, place->size() + 8);
    }
  }
  return text_of(words).substr(0, max_size);
}

} // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  setenv("KINDLING_OIDN", "/nowhere", 1); // --version opens a denoiser; the sanitizers cannot run beside some
  return 0;
}

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed) {
  return mutate_in_place(data, size, max_size, seed, mutate_words);
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  static const InputFolder folder;
  static const bool inside = chdir(folder.path().c_str()) == 0; // names are looked up there
  require(inside, "the folder can be entered");
  const std::vector<std::string> words = words_of(input_text(data, size));
  std::vector<const char*> arguments;
  for (const std::string& word : words) arguments.push_back(word.c_str());
  const Result<app::CommandLine> line = app::parse_command_line(arguments);
  if (!line) {
    require(line.error().kind == ErrorKind::usage || line.error().kind == ErrorKind::input_output,
            "flags are wrong usage");
    require(!line.error().message.empty(), "an error has a message");
  }
  static_cast<void>(app::help_hint(arguments));
  return 0;
}
