// The factory of engines, and the file of submitted jobs.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/distributed/farm_engine.h"

#include "renderer/distributed/json_file.h"
#include "renderer/distributed/slurm_engine.h"

#include <fmt/format.h>

namespace kindling {

Result<void> write_jobs(const std::filesystem::path& folder, const FarmJobs& jobs) {
  nlohmann::ordered_json json;
  json["arrays"] = nlohmann::ordered_json::array();
  for (const FarmArray& array : jobs.arrays) json["arrays"].push_back({{"id", array.id}, {"tasks", array.tasks}});
  json["merge"] = jobs.merge_id;
  return write_json_file(folder / "jobs.json", json);
}

Result<FarmJobs> read_jobs(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "jobs.json";
  std::error_code error;
  if (!std::filesystem::exists(file, error)) return FarmJobs{};
  Result<nlohmann::ordered_json> json = read_json_file(file);
  if (!json.ok()) return json.error();
  try {
    FarmJobs jobs;
    for (const auto& array : json.value().at("arrays"))
      jobs.arrays.push_back({array.at("id").get<std::string>(), whole_numbers(array, "tasks")});
    jobs.merge_id = json.value().at("merge").get<std::string>();
    return jobs;
  } catch (const NotAWholeNumber& wrong) {
    return Error{ErrorKind::input_output, fmt::format("{}: {}", file.string(), wrong.message)};
  } catch (const nlohmann::json::exception& exception) {
    return Error{ErrorKind::input_output, fmt::format("{}: {}", file.string(), exception.what())};
  }
}

Result<std::unique_ptr<FarmEngine>> make_farm_engine(std::string_view name) {
  if (name == "slurm") return std::unique_ptr<FarmEngine>(std::make_unique<SlurmEngine>());
  return Error{ErrorKind::usage, fmt::format("unknown engine '{}'; use slurm", name)};
}

} // namespace kindling
