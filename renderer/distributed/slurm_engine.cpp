// Slurm job scripts, and calls of Slurm's client programs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/slurm_engine.h"

#include "renderer/distributed/run_process.h"
#include "renderer/image/atomic_file.h"

#include <fmt/format.h>

#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cctype>
#include <charconv>
#include <cstdlib>

namespace kindling {

namespace {

constexpr int kDefaultLargestArray = 1001;

// Quotes one word for a POSIX shell.
std::string quote(const std::string& word) {
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value != nullptr ? value : "";
}

template <typename Number>
Number parse_number_or(std::string_view text, Number otherwise) {
  Number number = otherwise;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc() && end == text.data() + text.size() ? number : otherwise;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> pieces;
  for (size_t begin = 0; begin <= text.size();) {
    const size_t end = std::min(text.find(separator, begin), text.size());
    pieces.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return pieces;
}

std::string_view trimmed(std::string_view text) {
  const size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

Result<void> write_script(const std::filesystem::path& path, const std::string& text) {
  Result<AtomicFile> file = AtomicFile::create(path);
  if (!file.ok()) return file.error();
  file.value().write(text.data(), text.size());
  if (Result<void> written = file.value().commit(); !written.ok()) return written;
  std::error_code error;
  std::filesystem::permissions(path, std::filesystem::perms::owner_exec, std::filesystem::perm_options::add, error);
  return {};
}

// Runs one of Slurm's programs and returns its standard output.
Result<std::string> run_slurm(const std::vector<std::string>& command) {
  Result<ProcessOutput> output = capture_process(command);
  if (!output.ok())
    return Error{ErrorKind::input_output, output.error().message + "; are Slurm's client programs installed here?"};
  if (output.value().exit_code != 0)
    return Error{ErrorKind::input_output, fmt::format("{}: exit code {}: {}", command[0], output.value().exit_code,
                                                      trimmed(output.value().err))};
  return std::move(output).value().out;
}

std::string script_header(const FarmPlan& plan, std::string_view name, std::string_view log) {
  std::string text = "#!/bin/sh\n";
  text += fmt::format("#SBATCH --job-name={}\n#SBATCH --output={}\n#SBATCH --open-mode=append\n#SBATCH --requeue\n",
                      name, log);
  text += "#SBATCH --nodes=1\n#SBATCH --ntasks=1\n";
  if (!plan.resources.partition.empty()) text += fmt::format("#SBATCH --partition={}\n", plan.resources.partition);
  return text;
}

} // namespace

std::string slurm_array_script(const FarmPlan& plan, std::span<const int> tasks) {
  assert(!tasks.empty() && std::is_sorted(tasks.begin(), tasks.end()));
  const FarmResources& wanted = plan.resources;
  std::string text = script_header(plan, "kindling", "logs/%A_%a.log");
  text += fmt::format("#SBATCH --array=0-{}\n", tasks.size() - 1);
  if (wanted.threads_per_part > 0)
    text += fmt::format("#SBATCH --cpus-per-task={}\n", wanted.threads_per_part);
  else
    text += "#SBATCH --exclusive\n";
  if (!wanted.memory.empty()) text += fmt::format("#SBATCH --mem={}\n", wanted.memory);
  if (!wanted.time.empty()) text += fmt::format("#SBATCH --time={}\n", wanted.time);
  // B: signals the script's process alone, which `exec` below turns into `farm work`. Slurm may be
  // up to a minute early.
  text += fmt::format("#SBATCH --signal=B:USR1@{}\n", time_warning_s(wanted));
  std::string task = fmt::format("\"$(({} + SLURM_ARRAY_TASK_ID))\"", tasks.front());
  if (static_cast<size_t>(tasks.back() - tasks.front() + 1) != tasks.size()) { // not consecutive: look the number up
    std::string words;
    for (const int number : tasks) words += fmt::format(" {}", number);
    text += fmt::format("set --{}\nshift \"$SLURM_ARRAY_TASK_ID\"\n", words);
    task = "\"$1\"";
  }
  return text + fmt::format("exec {} farm work {} {}\n", quote(plan.binary), quote(plan.folder), task);
}

std::string slurm_merge_script(const FarmPlan& plan) {
  return script_header(plan, "kindling-merge", "logs/merge_%j.log") +
         fmt::format("exec {} farm merge {}\n", quote(plan.binary), quote(plan.folder));
}

Result<std::string> parse_sbatch(std::string_view output) {
  const std::string_view id = trimmed(output.substr(0, output.find(';')));
  if (!id.empty() && std::all_of(id.begin(), id.end(), [](char c) { return c >= '0' && c <= '9'; }))
    return std::string(id);
  return Error{ErrorKind::input_output, fmt::format("sbatch: '{}' is not a job number", trimmed(output))};
}

FarmQueue parse_squeue(std::string_view output, const FarmJobs& jobs) {
  FarmQueue queue;
  for (const std::string_view line : split(output, '\n')) {
    const std::vector<std::string_view> fields = split(trimmed(line), '|');
    if (fields.size() < 5) continue;
    if (fields[0] == jobs.merge_id) queue.merge = true;
    const auto array = std::find_if(jobs.arrays.begin(), jobs.arrays.end(),
                                    [&](const FarmArray& candidate) { return fields[0] == candidate.id; });
    const auto index = parse_number_or<size_t>(fields[1], ~size_t{0});
    if (array == jobs.arrays.end() || index >= array->tasks.size()) continue;
    // All other states (requeued, suspended and so on) count as waiting.
    const bool running = fields[2] == "RUNNING" || fields[2] == "COMPLETING" || fields[2] == "CONFIGURING";
    queue.tasks[array->tasks[index]] = {running ? QueueState::running : QueueState::waiting,
                                        running ? std::string(fields[3]) : std::string(), std::string(fields[4])};
  }
  return queue;
}

int parse_largest_array(std::string_view output) {
  constexpr std::string_view kName = "MaxArraySize";
  for (const std::string_view line : split(output, '\n'))
    if (line.starts_with(kName) && line.find('=') != std::string_view::npos)
      return std::max(1, parse_number_or(trimmed(line.substr(line.find('=') + 1)), kDefaultLargestArray));
  return kDefaultLargestArray;
}

namespace {

// Parses a time of Slurm: minutes, minutes:seconds, hours:minutes:seconds, days-hours,
// days-hours:minutes or days-hours:minutes:seconds.
std::optional<int64_t> parse_time_s(std::string_view text) {
  constexpr int64_t kMinute = 60, kHour = 60 * kMinute, kDay = 24 * kHour;
  const size_t dash = text.find('-');
  const bool has_days = dash != std::string_view::npos;
  std::vector<int64_t> numbers;
  for (const std::string_view word : split(has_days ? text.substr(dash + 1) : text, ':')) {
    numbers.push_back(parse_number_or<int64_t>(word, -1));
    if (numbers.back() < 0 || numbers.back() > 1'000'000'000) return std::nullopt;
  }
  if (numbers.size() > 3) return std::nullopt;
  if (has_days) {
    const int64_t days = parse_number_or<int64_t>(text.substr(0, dash), -1);
    if (days < 0 || days > 1'000'000) return std::nullopt;
    numbers.resize(3);
    return days * kDay + numbers[0] * kHour + numbers[1] * kMinute + numbers[2];
  }
  if (numbers.size() == 3) return numbers[0] * kHour + numbers[1] * kMinute + numbers[2];
  numbers.resize(2);
  return numbers[0] * kMinute + numbers[1];
}

bool is_partition_list(std::string_view text) {
  for (const std::string_view name : split(text, ',')) {
    const auto allowed = [](char c) {
      return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-' ||
             c == '.' || c == '+';
    };
    if (name.empty() || name.front() == '-' || !std::all_of(name.begin(), name.end(), allowed)) return false;
  }
  return true;
}

bool is_memory(std::string_view text) {
  if (!text.empty() && std::string_view("KMGTkmgt").find(text.back()) != std::string_view::npos) text.remove_suffix(1);
  return parse_number_or<int64_t>(text, -1) >= 0;
}

bool is_time_limit(std::string_view text) {
  std::string upper(text);
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return upper == "UNLIMITED" || upper == "INFINITE" || parse_time_s(text);
}

} // namespace

std::optional<int64_t> slurm_time_s(std::string_view text) {
  constexpr int64_t kMinute = 60;
  const std::optional<int64_t> seconds = parse_time_s(text);
  if (!seconds || *seconds == 0) return std::nullopt; // no limit
  return (*seconds + kMinute - 1) / kMinute * kMinute;
}

int64_t time_warning_s(const FarmResources& resources) {
  constexpr int64_t kMax = 60;
  const std::optional<int64_t> limit = slurm_time_s(resources.time);
  return limit ? std::min(kMax, *limit / 4) : kMax;
}

Result<void> check_slurm_resources(const FarmResources& wanted) {
  const auto check = [](const char* flag, const std::string& word, bool (*valid)(std::string_view),
                        const char* accepted) -> Result<void> {
    if (word.empty() || valid(word)) return {};
    return usage_error(fmt::format("{}: '{}' is no value for Slurm; use {}", flag, word, accepted));
  };
  if (Result<void> checked = check("--partition", wanted.partition, is_partition_list,
                                   "the name of a partition, or several separated by commas");
      !checked.ok())
    return checked;
  if (Result<void> checked =
          check("--memory", wanted.memory, is_memory, "a whole number of megabytes, or with a unit K, M, G or T: 4G");
      !checked.ok())
    return checked;
  return check("--time", wanted.time, is_time_limit,
               "minutes, MINUTES:SECONDS, H:MM:SS, DAYS-HOURS, DAYS-HH:MM, DAYS-HH:MM:SS or UNLIMITED");
}

Result<void> SlurmEngine::check(const FarmResources& resources) const { return check_slurm_resources(resources); }

Result<FarmJobs> SlurmEngine::submit(const FarmPlan& plan, std::span<const int> tasks) {
  if (Result<void> checked = check_slurm_resources(plan.resources); !checked.ok()) return checked.error();
  Result<std::string> configuration = run_slurm({"scontrol", "show", "config"});
  if (!configuration.ok()) return configuration.error();
  const auto largest = static_cast<size_t>(parse_largest_array(configuration.value()));

  FarmJobs jobs;
  std::vector<std::string> submitted;
  // After a failure, the jobs submitted so far are cancelled: half a farm is useless.
  const auto give_up = [&](const Error& error) {
    if (!submitted.empty()) {
      submitted.insert(submitted.begin(), "scancel");
      (void)capture_process(submitted).ok();
    }
    return error;
  };
  const auto hand_over = [&](const std::string& name, const std::string& script,
                             std::vector<std::string> more) -> Result<std::string> {
    const std::filesystem::path path = plan.folder / name;
    if (Result<void> written = write_script(path, script); !written.ok()) return written.error();
    std::vector<std::string> command{"sbatch", "--parsable", "--chdir=" + plan.folder.string()};
    command.insert(command.end(), std::make_move_iterator(more.begin()), std::make_move_iterator(more.end()));
    command.push_back(path.string());
    Result<std::string> output = run_slurm(command);
    return output.ok() ? parse_sbatch(output.value()) : output;
  };

  std::string dependency = "--dependency=afterany";
  for (size_t first = 0; first < tasks.size(); first += largest) {
    const std::span<const int> some = tasks.subspan(first, std::min(largest, tasks.size() - first));
    Result<std::string> id =
        hand_over(fmt::format("render-{}.sh", jobs.arrays.size() + 1), slurm_array_script(plan, some), {});
    if (!id.ok()) return give_up(id.error());
    submitted.push_back(id.value());
    dependency += ":" + id.value();
    jobs.arrays.push_back({std::move(id).value(), {some.begin(), some.end()}});
  }
  std::vector<std::string> after;
  if (!jobs.arrays.empty()) after.push_back(dependency);
  Result<std::string> merge = hand_over("merge.sh", slurm_merge_script(plan), after);
  if (!merge.ok()) return give_up(merge.error());
  jobs.merge_id = std::move(merge).value();
  return jobs;
}

Result<FarmQueue> SlurmEngine::queue(const FarmJobs& jobs) {
  // Asks for all jobs of the user: squeue fails for numbers of jobs that it has forgotten.
  Result<std::string> output =
      run_slurm({"squeue", "--noheader", "--array", "--all", "--me", "--format=" + std::string(kSqueueFormat)});
  if (!output.ok()) return output.error();
  return parse_squeue(output.value(), jobs);
}

bool SlurmEngine::inside_task() const { return !environment("SLURM_ARRAY_JOB_ID").empty(); }

Result<void> SlurmEngine::requeue_this_task() {
  Result<std::string> output =
      run_slurm({"scontrol", "requeue", environment("SLURM_ARRAY_JOB_ID") + "_" + environment("SLURM_ARRAY_TASK_ID")});
  if (!output.ok()) return output.error();
  return {};
}

int SlurmEngine::threads_of_this_task() const {
  const int asked = parse_number_or(environment("SLURM_CPUS_PER_TASK"), 0);
  return asked > 0 ? asked : parse_number_or(environment("SLURM_CPUS_ON_NODE"), 0);
}

std::string SlurmEngine::log_of_this_task() const {
  if (!inside_task()) return {};
  return fmt::format("logs/{}_{}.log", environment("SLURM_ARRAY_JOB_ID"), environment("SLURM_ARRAY_TASK_ID"));
}

std::string SlurmEngine::host_of_this_task() const {
  if (std::string node = environment("SLURMD_NODENAME"); !node.empty()) return node;
  char name[256] = "";
  gethostname(name, sizeof name - 1);
  return name;
}

} // namespace kindling
