// write_slips FOLDER: writes each file of the corpus, and slips.json with what loads make of it.
// SPDX-License-Identifier: Apache-2.0
#include "tests/import/slips.h"

#include <algorithm>
#include <cstdio>
#include <fstream>

using namespace kindling::test;

namespace {

class Writer {
 public:
  explicit Writer(std::filesystem::path folder) : folder_(std::move(folder)) {
    std::filesystem::create_directories(folder_);
  }

  void write(std::string_view name, const char* extension, const std::string& content, std::string_view fault,
             std::string_view remedy) {
    std::string file(name);
    std::replace_if(
        file.begin(), file.end(), [](char c) { return c == ' ' || c == '.'; }, '_');
    file += extension;
    std::ofstream(folder_ / file, std::ios::binary) << content;
    list_.push_back({{"file", file}, {"fault", fault}, {"repaired", !remedy.empty()}, {"remedy", remedy}});
  }

  [[nodiscard]] bool finish() const {
    std::ofstream stream(folder_ / "slips.json");
    stream << list_.dump(1) << "\n";
    return stream.good();
  }

 private:
  std::filesystem::path folder_;
  json list_ = json::array();
};

} // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: write_slips FOLDER\n");
    return 2;
  }
  Writer writer(argv[1]);
  for (const Slip& slip : slips()) writer.write(slip.name, ".gltf", with_slip(slip).gltf(), slip.fault, slip.remedy);
  for (const DataSlip& slip : data_slips()) {
    GltfBuilder builder = sound_file();
    slip.change(builder);
    writer.write(slip.name, ".gltf", builder.gltf(), slip.fault, slip.remedy);
  }
  for (const ContainerSlip& slip : container_slips()) {
    std::string bytes = sound_file().glb();
    slip.change(bytes);
    writer.write("container " + std::string(slip.name), ".glb", bytes, slip.fault, slip.remedy);
  }
  return writer.finish() ? 0 : 1;
}
