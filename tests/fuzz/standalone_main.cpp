// Runs a harness without libFuzzer: all files of a corpus, then mutants of them for some seconds.
//
//   fuzz_KIND [-max_total_time=SECONDS] [-timeout=SECONDS] [-seed=N] [-artifact_prefix=PREFIX]
//             FILE_OR_FOLDER...
// Mutants are chosen without regard to coverage. The names of flags and statistics are libFuzzer's,
// so that run.py can run both; libFuzzer's other flags are ignored.
// SPDX-License-Identifier: Apache-2.0
#include "tests/fuzz/mutators/random.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <fcntl.h>
#include <signal.h>
#include <sys/mman.h>
#include <unistd.h>

extern "C" {
int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size);
__attribute__((weak)) int LLVMFuzzerInitialize(int* argc, char*** argv);
__attribute__((weak)) size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned seed);
size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size);
// The sanitizers' runtime has these two; without it they are null.
__attribute__((weak)) void __sanitizer_set_death_callback(void (*callback)());
__attribute__((weak)) void __sanitizer_print_stack_trace();
}

namespace kindling::fuzz {
namespace {

constexpr size_t kMaxSize = 1 << 17;

Random& mutations() {
  static Random random(1);
  return random;
}

// The input in work, in a file that outlives the process.
class Artifact {
 public:
  explicit Artifact(const std::string& prefix) : name_(prefix + "input") {
    const int fd = open(name_.c_str(), O_RDWR | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    if (fd < 0 || ftruncate(fd, kMaxSize) != 0) std::abort();
    bytes_ = static_cast<char*>(mmap(nullptr, kMaxSize, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0));
    close(fd);
    if (bytes_ == MAP_FAILED) std::abort();
  }
  void store(const std::string& input) {
    size_ = input.size();
    std::memcpy(bytes_, input.data(), size_);
  }
  // Async-signal-safe.
  void cut() const { static_cast<void>(!truncate(name_.c_str(), static_cast<off_t>(size_))); }
  void remove() const { unlink(name_.c_str()); }

 private:
  std::string name_;
  char* bytes_ = nullptr;
  size_t size_ = 0;
};

Artifact* artifact = nullptr;

extern "C" void cut_artifact() {
  if (artifact != nullptr) artifact->cut();
}

extern "C" void on_signal(int number) {
  cut_artifact();
  if (number == SIGALRM) {
    static constexpr char kText[] = "SUMMARY: standalone: timeout\n";
    static_cast<void>(!write(STDERR_FILENO, kText, sizeof kText - 1));
    if (__sanitizer_print_stack_trace != nullptr) __sanitizer_print_stack_trace();
  }
  signal(number == SIGALRM ? SIGABRT : number, SIG_DFL);
  raise(number == SIGALRM ? SIGABRT : number);
}

std::vector<std::string> read_corpus(const std::vector<std::string>& names) {
  std::vector<std::filesystem::path> files;
  for (const std::string& name : names) {
    if (!std::filesystem::is_directory(name)) {
      files.emplace_back(name);
      continue;
    }
    for (const auto& entry : std::filesystem::directory_iterator(name)) files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<std::string> corpus;
  for (const std::filesystem::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    corpus.back().resize(std::min(corpus.back().size(), kMaxSize));
  }
  return corpus;
}

struct Settings {
  double seconds = 0.0;
  unsigned timeout_s = 20;
  unsigned seed = 1;
  std::string prefix = "./";
  std::vector<std::string> names;
};

Settings parse(int argc, char** argv) {
  Settings settings;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string value = word.substr(std::min(word.find('=') + 1, word.size()));
    if (word.starts_with("-max_total_time="))
      settings.seconds = std::atof(value.c_str());
    else if (word.starts_with("-timeout="))
      settings.timeout_s = static_cast<unsigned>(std::atoi(value.c_str()));
    else if (word.starts_with("-seed="))
      settings.seed = static_cast<unsigned>(std::atoi(value.c_str()));
    else if (word.starts_with("-artifact_prefix="))
      settings.prefix = value;
    else if (!word.starts_with('-'))
      settings.names.push_back(word);
  }
  return settings;
}

std::string mutant_of(const std::string& input, Random& random) {
  std::string mutant = input;
  mutant.resize(kMaxSize);
  auto* bytes = reinterpret_cast<uint8_t*>(mutant.data());
  size_t size = input.size();
  for (size_t i = 0, count = 1 + random.below(3); i < count; ++i)
    size = LLVMFuzzerCustomMutator != nullptr ? LLVMFuzzerCustomMutator(bytes, size, kMaxSize, random.seed())
                                              : LLVMFuzzerMutate(bytes, size, kMaxSize);
  mutant.resize(size);
  return mutant;
}

int run(int argc, char** argv) {
  using Clock = std::chrono::steady_clock;
  const Settings settings = parse(argc, argv);
  if (LLVMFuzzerInitialize != nullptr) LLVMFuzzerInitialize(&argc, &argv);
  Artifact input(settings.prefix);
  artifact = &input;
  signal(SIGALRM, on_signal);
  signal(SIGABRT, on_signal);
  if (__sanitizer_set_death_callback != nullptr)
    __sanitizer_set_death_callback(cut_artifact); // it reports the other signals itself
  else
    for (const int number : {SIGSEGV, SIGFPE, SIGBUS, SIGILL}) signal(number, on_signal);
  const auto test = [&](const std::string& bytes) {
    input.store(bytes);
    alarm(settings.timeout_s);
    // A copy of exactly this size, so that a read beyond its end is seen.
    const std::vector<uint8_t> exact(bytes.begin(), bytes.end());
    LLVMFuzzerTestOneInput(exact.data(), exact.size());
  };
  const auto start = Clock::now();
  const std::vector<std::string> corpus = read_corpus(settings.names);
  uint64_t executions = 0;
  for (const std::string& bytes : corpus) {
    test(bytes);
    ++executions;
  }
  Random random(settings.seed);
  mutations() = Random(settings.seed);
  const auto elapsed_s = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  while (!corpus.empty() && elapsed_s() < settings.seconds) {
    test(mutant_of(corpus[random.below(corpus.size())], random));
    ++executions;
  }
  alarm(0);
  artifact = nullptr;
  input.remove();
  std::fprintf(stderr, "stat::number_of_executed_units: %llu\nDone in %.1f s\n",
               static_cast<unsigned long long>(executions), elapsed_s());
  return 0;
}

} // namespace
} // namespace kindling::fuzz

// Changes, inserts, copies or removes some bytes.
extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t max_size) {
  using kindling::fuzz::Random;
  Random& random = kindling::fuzz::mutations();
  static constexpr uint8_t kBytes[] = {0, 1, 2, 16, 32, 64, 100, 127, 128, 254, 255, ' ', '\n', '"', '-', '0', '9'};
  std::string bytes(reinterpret_cast<char*>(data), size);
  const auto other = [&] {
    return static_cast<char>(random.one_in(2) ? kBytes[random.below(sizeof kBytes)] : random.below(256));
  };
  const size_t at = random.below(bytes.size() + 1);
  const size_t length = std::min(1 + random.below(random.one_in(8) ? 256 : 8), bytes.size() - at);
  switch (random.below(8)) {
  case 0: bytes.erase(at, length); break;
  case 1: bytes.insert(at, 1 + random.below(8), other()); break;
  case 2: bytes.insert(at, std::string(bytes, at, length)); break;
  case 3:
    if (length >= 4) { // a number near the end of its type, or small
      const uint32_t number =
          random.one_in(2) ? static_cast<uint32_t>(random.below(256)) : ~static_cast<uint32_t>(random.below(3));
      std::memcpy(bytes.data() + at, &number, sizeof number);
      break;
    }
    [[fallthrough]];
  default:
    if (at < bytes.size()) bytes[at] = random.one_in(3) ? static_cast<char>(bytes[at] ^ 1 << random.below(8)) : other();
  }
  size = std::min(bytes.size(), max_size);
  std::memcpy(data, bytes.data(), size);
  return size;
}

int main(int argc, char** argv) { return kindling::fuzz::run(argc, argv); }
