// Task numbers and file names of a farm's plan; reading and writing of plan.json.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_plan.h"

#include "renderer/distributed/json_file.h"
#include "renderer/session/json_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstdlib>

namespace kindling {

namespace {

constexpr int kPlanVersion = 1;
constexpr int64_t kMaxTasks = 1'000'000; // limit of `farm submit`

template <typename Texts>
nlohmann::ordered_json texts_to_json(const Texts& texts) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const auto& text : texts) json.push_back(text_to_json(text));
  return json;
}

// Throws NotAText.
struct NotAText {
  std::string key;
};
std::string read_text(const nlohmann::ordered_json& json, const char* key) {
  std::optional<std::string> text = text_from_json(json);
  if (!text) throw NotAText{key};
  return *std::move(text);
}

template <typename Text>
std::vector<Text> read_texts(const nlohmann::ordered_json& json, const char* key) {
  if (!json.is_array()) throw NotAText{key};
  std::vector<Text> texts;
  for (const nlohmann::ordered_json& text : json) texts.emplace_back(read_text(text, key));
  return texts;
}

nlohmann::ordered_json plan_json(const FarmPlan& plan) {
  nlohmann::ordered_json json;
  json["version"] = kPlanVersion;
  json["program"] = plan.program;
  json["binary"] = text_to_json(plan.binary.string());
  json["scene"] = text_to_json(plan.scene.string());
  json["working_folder"] = text_to_json(plan.working_folder.string());
  json["flags"] = texts_to_json(plan.flags);
  json["frames"] = plan.frames;
  json["parts"] = plan.parts;
  json["outputs"] = texts_to_json(plan.outputs);
  json["retries"] = plan.retries;
  json["engine"] = plan.engine;
  json["resources"] = {{"partition", plan.resources.partition},
                       {"threads_per_part", plan.resources.threads_per_part},
                       {"memory", plan.resources.memory},
                       {"time", plan.resources.time}};
  return json;
}

FarmPlan from_json(const nlohmann::ordered_json& json) {
  FarmPlan plan;
  plan.program = json.at("program").get<std::string>();
  plan.binary = read_text(json.at("binary"), "binary");
  plan.scene = read_text(json.at("scene"), "scene");
  plan.working_folder = read_text(json.at("working_folder"), "working_folder");
  plan.flags = read_texts<std::string>(json.at("flags"), "flags");
  plan.frames = whole_numbers(json, "frames");
  plan.parts = whole_number(json, "parts");
  plan.outputs = read_texts<std::filesystem::path>(json.at("outputs"), "outputs");
  plan.retries = whole_number(json, "retries");
  plan.engine = json.at("engine").get<std::string>();
  const nlohmann::ordered_json& resources = json.at("resources");
  plan.resources = {resources.at("partition").get<std::string>(), whole_number(resources, "threads_per_part"),
                    resources.at("memory").get<std::string>(), resources.at("time").get<std::string>()};
  return plan;
}

} // namespace

FarmTask FarmPlan::task(int number) const {
  assert(number >= 0 && number < task_count());
  return {number, frame(number / parts), number % parts + 1};
}

std::optional<int> FarmPlan::frame(int index) const {
  if (frames.empty()) return std::nullopt;
  return frames[static_cast<size_t>(index)];
}

std::string FarmPlan::task_name(const FarmTask& task) const {
  const std::string part = fmt::format("part-{:03}", task.part);
  return task.frame ? with_frame_number(kFramePattern, *task.frame) + "-" + part : part;
}

std::filesystem::path FarmPlan::part_file(const FarmTask& task) const {
  return folder / "parts" / (task_name(task) + ".kacc");
}
std::filesystem::path FarmPlan::unfinished_file(const FarmTask& task) const {
  return folder / "parts" / (task_name(task) + ".unfinished.kacc");
}
std::filesystem::path FarmPlan::checkpoint_file(const FarmTask& task) const {
  return folder / "parts" / (task_name(task) + ".checkpoint.kacc");
}
std::filesystem::path FarmPlan::task_record_file(const FarmTask& task) const {
  return folder / "state" / (task_name(task) + ".json");
}
std::filesystem::path FarmPlan::stats_file(const FarmTask& task) const {
  return folder / "state" / (task_name(task) + ".stats.json");
}
std::filesystem::path FarmPlan::frame_record_file(int index) const {
  const std::optional<int> number = frame(index);
  return folder / "state" / (number ? with_frame_number(kFramePattern, *number) + ".json" : "image.json");
}
std::filesystem::path FarmPlan::refusal_file() const { return folder / "state" / "refused.json"; }

std::vector<std::filesystem::path> FarmPlan::outputs_of(int index) const {
  std::vector<std::filesystem::path> paths;
  const std::optional<int> number = frame(index);
  for (const std::filesystem::path& output : outputs)
    paths.push_back(number ? output.parent_path() / with_frame_number(output.filename().string(), *number) : output);
  return paths;
}

std::string with_frame_number(std::string_view name, int frame) {
  const size_t begin = name.find('#');
  if (begin == std::string_view::npos) return std::string(name);
  const size_t end = std::min(name.find_first_not_of('#', begin), name.size());
  return fmt::format("{}{}{:0{}}{}", name.substr(0, begin), frame < 0 ? "-" : "", std::abs(int64_t{frame}), end - begin,
                     name.substr(end));
}

Result<void> write_new_plan(const FarmPlan& plan) {
  const std::filesystem::path file = plan.folder / "plan.json";
  std::error_code error;
  if (std::filesystem::exists(file, error))
    return Error{ErrorKind::usage, fmt::format("{}: exists already; a farm needs a folder of its own", file.string())};
  for (const char* name : {"parts", "state", "logs"}) {
    std::filesystem::create_directories(plan.folder / name, error);
    if (error)
      return Error{ErrorKind::input_output,
                   fmt::format("{}: cannot be created: {}", (plan.folder / name).string(), error.message())};
  }
  return write_json_file(file, plan_json(plan));
}

Result<FarmPlan> read_plan(const std::filesystem::path& folder) {
  std::error_code error;
  const std::filesystem::path absolute = std::filesystem::weakly_canonical(folder, error);
  const std::filesystem::path file = (error ? folder : absolute) / "plan.json";
  Result<nlohmann::ordered_json> json = read_json_file(file);
  if (!json.ok()) return json.error();
  const auto broken = [&](std::string_view what) {
    return Error{ErrorKind::input_output, fmt::format("{}: {}", file.string(), what)};
  };
  try {
    if (const int version = whole_number(json.value(), "version"); version != kPlanVersion)
      return broken(fmt::format("a plan of version {}; this program supports {}", version, kPlanVersion));
    FarmPlan plan = from_json(json.value());
    plan.folder = file.parent_path();
    if (plan.parts < 1) return broken("a plan without parts");
    const auto frames = static_cast<int64_t>(std::max<size_t>(plan.frames.size(), 1));
    if (frames * plan.parts > kMaxTasks)
      return broken(fmt::format("a plan of {} frames in {} parts: more than {} tasks", frames, plan.parts, kMaxTasks));
    return plan;
  } catch (const NotAText& wrong) {
    return broken(fmt::format("not a plan of a farm: '{}' has something else than texts", wrong.key));
  } catch (const NotAWholeNumber& wrong) {
    return broken("not a plan of a farm: " + wrong.message);
  } catch (const nlohmann::json::exception& exception) {
    return broken(fmt::format("not a plan of a farm: {}", exception.what()));
  }
}

} // namespace kindling
