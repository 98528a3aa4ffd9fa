// Material variants and the extensions of materials on the command line.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/decode_image.h"
#include "renderer/import/load_gltf.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstring>

namespace kindling::test {
namespace {

class VariantCommand : public SceneFolder {
 protected:
  // The square of write_scene(), blue and in the variant "ember" red, both unlit.
  [[nodiscard]] std::string write_variants() const {
    TestSceneOptions options;
    options.light = false;
    const std::string name = write_scene("variants", options);
    nlohmann::json root = nlohmann::json::parse(read_file(name));
    root["materials"] = nlohmann::json::parse(R"([
      {"name": "blue", "pbrMetallicRoughness": {"baseColorFactor": [0, 0, 1, 1]}, "extensions": {"KHR_materials_unlit": {}}},
      {"name": "red", "pbrMetallicRoughness": {"baseColorFactor": [1, 0, 0, 1]},
       "extensions": {"KHR_materials_unlit": {}, "ACME_materials_velvet_with_a_name_longer_than_any_cell_of_a_table": {}}}])");
    root["extensions"]["KHR_materials_variants"]["variants"] =
        nlohmann::json::parse(R"([{"name": "sky"}, {"name": "ember"}])");
    root["meshes"][0]["primitives"][0]["extensions"]["KHR_materials_variants"]["mappings"] =
        nlohmann::json::parse(R"([{"material": 1, "variants": [1]}])");
    write_file(name, root.dump());
    return name;
  }
  // The pixel in the middle of the square.
  [[nodiscard]] std::array<float, 3> color_of(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), {"--size", "3x3", "--spp", "1", "--exr-float", "-o", "a.exr"});
    const ProgramResult result = run_program(arguments, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    Result<Image> image = read_image_file(folder_ / "a.exr");
    std::array<float, 3> color{-1.0f, -1.0f, -1.0f};
    if (image.ok()) std::memcpy(color.data(), image.value().pixels.data() + 4 * 4 * sizeof(float), sizeof(color));
    return color;
  }
};

TEST_F(VariantCommand, RendersTheRequestedVariant) {
  const std::string scene = write_variants();
  const std::array<float, 3> red{1, 0, 0};
  const std::array<float, 3> blue{0, 0, 1};
  EXPECT_EQ(color_of({"render", scene}), blue);
  EXPECT_EQ(color_of({"render", scene, "--variant", "ember"}), red);
  EXPECT_EQ(color_of({"render", scene, "--variant", "1"}), red);
  EXPECT_EQ(color_of({"render", scene, "--variant", "sky"}), blue) << "which no primitive has a material for";
}

TEST_F(VariantCommand, RefusesUnknownVariants) {
  const std::string scene = write_variants();
  for (const char* command : {"render", "info", "shootout"}) {
    const ProgramResult result = run_program({command, scene, "--variant", "green"}, folder_);
    EXPECT_EQ(result.exit_code, 2) << command;
    const std::string message = "--variant: variants.gltf has no variant 'green'; use 0 (sky) or 1 (ember)";
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
  }
  const ProgramResult none = run_program({"render", write_scene(), "--variant", "green"}, folder_);
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("scene.gltf has no variants; leave out the flag"), std::string::npos) << none.err;
}

TEST_F(VariantCommand, InfoListsVariantsAndMaterialExtensions) {
  const std::string scene = write_variants();
  const auto json = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {scene, "--json"});
    return nlohmann::json::parse(run_program(arguments, folder_).out);
  };
  const nlohmann::json plain = json({"info"});
  EXPECT_EQ(plain["variants"], (nlohmann::json{"sky", "ember"}));
  EXPECT_EQ(plain["shown_variant"], nullptr);
  EXPECT_EQ(plain["materials"][0]["primitives"], 1);
  EXPECT_EQ(plain["materials"][1]["primitives"], 0);
  const std::string unknown = "ACME_materials_velvet_with_a_name_longer_than_any_cell_of_a_table";
  EXPECT_EQ(plain["materials"][1]["extensions"], (nlohmann::json{unknown, "KHR_materials_unlit"}));
  EXPECT_EQ(plain["materials"][1]["extension_support"],
            (nlohmann::json{{unknown, "unknown"}, {"KHR_materials_unlit", "full"}}));
  const nlohmann::json ember = json({"info", "--variant", "ember"});
  EXPECT_EQ(ember["shown_variant"], 1);
  EXPECT_EQ(ember["materials"][0]["primitives"], 0);
  EXPECT_EQ(ember["materials"][1]["primitives"], 1);

  const std::string tables = run_program({"info", scene, "--variant", "ember"}, folder_).out;
  EXPECT_NE(tables.find("1  ember  shown here\n"), std::string::npos) << tables;
  EXPECT_NE(tables.find(unknown + " (unknown), KHR_materials_unlit\n"), std::string::npos) << tables;
}

TEST_F(VariantCommand, PrintsTheExtensionTableOfTheImporter) {
  const ProgramResult result = run_program({"info", "--extension-table"}, folder_);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.out, extension_table_markdown());
}

} // namespace
} // namespace kindling::test
