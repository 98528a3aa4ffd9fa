// Exit codes and messages of refused command lines.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/import/load_gltf.h"
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <nlohmann/json.hpp>

#include <cstdlib>
#include <fstream>

namespace kindling::test {
namespace {

class Usage : public SceneFolder {
 protected:
  // Expects one line of error with this exit code and these words.
  void expect_error(const std::vector<std::string>& arguments, int code, const std::string& words) const {
    SCOPED_TRACE(testing::PrintToString(arguments));
    const ProgramResult result = run_program(arguments, folder_);
    EXPECT_EQ(result.exit_code, code) << result.err;
    EXPECT_EQ(result.out, "");
    const std::vector<std::string> lines = result.err_lines();
    ASSERT_EQ(lines.size(), 1U) << result.err;
    EXPECT_TRUE(lines[0].starts_with("kindling: error: ")) << lines[0];
    EXPECT_NE(lines[0].find(words), std::string::npos) << lines[0];
    EXPECT_EQ(lines[0].find("--help") != std::string::npos, code == 2) << lines[0];
  }
};

TEST_F(Usage, WrongFlagsExitWith2) {
  const std::string scene = write_scene();
  expect_error({}, 2,
               "no command; use render, resume, info, shootout, scaling, merge, denoise, relight, view, farm, manual "
               "or completion");
  expect_error({"bake"}, 2, "unknown command 'bake'");
  expect_error({scene}, 2, "did you mean 'kindling render scene.gltf'?");
  expect_error({"render"}, 2, "no scene");
  expect_error({"render", scene, scene}, 2, "unexpected argument");
  expect_error({"render", scene, "--sppp", "4"}, 2, "unknown flag '--sppp'; did you mean --spp?");
  expect_error({"render", scene, "--samples", "4"}, 2, "unknown flag '--samples'; did you mean --spp?");
  expect_error({"render", scene, "--resolution=64x64"}, 2, "unknown flag '--resolution'; did you mean --size?");
  expect_error({"render", scene, "--spp"}, 2, "--spp: needs a value");
  expect_error({"render", scene, "--spp", "many"}, 2, "--spp: 'many' is not a whole number; use 1 to");
  expect_error({"render", scene, "--spp", "0"}, 2, "--spp: '0' is out of range");
  expect_error({"render", scene, "--size", "64"}, 2, "--size: '64' is not a size");
  expect_error({"render", scene, "--time-limit", "soon"}, 2, "--time-limit: 'soon' is not a duration");
  expect_error({"render", scene, "--background", "blue"}, 2, "use env, transparent or R,G,B");
  expect_error({"render", scene, "--aov", "beauty,shadow", "-o", "a.exr"}, 2, "unknown AOV 'shadow'");
  expect_error({"render", scene, "--filter", "sinc"}, 2, "--filter: unknown filter 'sinc'; use blackman-harris");
  expect_error({"render", scene, "--integrator", "magic"}, 2, "--integrator: unknown integrator 'magic'; use path");
  expect_error({"render", scene, "--sample", "3"}, 2, "--sample: has no meaning without --pixel");
  expect_error({"render", scene, "--env", "a.hdr", "--env-color", "1,1,1"}, 2, "give one of them");
  expect_error({"info"}, 2, "no scene");
  expect_error({"info", scene, "--list-cameras", "--list-scenes"}, 2,
               "give only one --list-... flag or --extension-table");
}

TEST_F(Usage, NamesKnownAccelerators) {
  const ProgramResult result = run_program({"render", write_scene(), "--accel", "bvh4"}, folder_);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(result.err, "kindling: error: --accel: unknown accelerator 'bvh4'; use kdtree, embree or brute-force "
                        "(try 'kindling render --help')\n");
}

TEST_F(Usage, MissingPartsOfTheSceneExitWith2) {
  const std::string scene = write_scene();
  expect_error({"render", scene, "--camera", "Side"}, 2, "has no camera 'Side'; use 0 (Front)");
  expect_error({"render", scene, "--scene", "Attic"}, 2, "has no scene 'Attic'; use 0 (Stage)");
  expect_error({"render", scene, "--size", "32x32", "--crop", "0,0,33,32"}, 2,
               "--crop: 0,0,33,32 is not inside the image");
  expect_error({"render", scene, "--size", "32x32", "--pixel", "32,0"}, 2, "--pixel: 32,0 is not inside the image");
}

TEST_F(Usage, NamesAConverterForOtherFormats) {
  std::ofstream(folder_ / "house.dae") << "<?xml version=\"1.0\"?>\n<COLLADA/>\n";
  const ProgramResult result = run_program({"render", "house.dae"}, folder_);
  EXPECT_EQ(result.exit_code, 3);
  EXPECT_EQ(result.err,
            "kindling: error: house.dae: a COLLADA file, not glTF; convert it with assimp: assimp export house.dae "
            "house.glb\n");
}

TEST_F(Usage, StrictInfoRefusesRepairableFaults) {
  const std::string scene = KINDLING_SCENES "/broken/rotation_is_zero.gltf";
  expect_error({"info", scene, "--strict"}, 3,
               scene + ": /nodes/0/rotation: a quaternion of length 0, expected length 1 (ROTATION_NON_UNIT)");
  for (const std::vector<std::string>& arguments :
       {std::vector<std::string>{"info", scene},
        {"render", scene, "-o", "a.png", "--size", "8x8", "--spp", "1", "--progress", "none"}}) {
    const ProgramResult result = run_program(arguments, folder_);
    EXPECT_EQ(result.exit_code, 0) << result.err;
    EXPECT_NE(result.err.find("(ROTATION_NON_UNIT); the node is not rotated\n"), std::string::npos) << result.err;
  }
  EXPECT_EQ(run_program({"info", KINDLING_SCENES "/cornell_box.glb", "--strict"}, folder_).exit_code, 0);
}

TEST_F(Usage, ChecksOutputsBeforeRendering) {
  const std::string scene = write_scene();
  expect_error({"render", scene, "-o", "a.bmp"}, 2, "unsupported image format '.bmp'; use .exr, .png or .jpg");
  expect_error({"render", scene, "-o", "a.png", "-o", "./a.png"}, 2, "given twice");
  expect_error({"render", scene, "-o", "-", "-o", "exr:-"}, 2, "- and exr:-: standard output takes one image");
  expect_error({"render", scene, "-o", "-", "--frames", "0-3"}, 2, "####");
  expect_error({"render", scene, "-o", "a.png", "--aov", "albedo"}, 2, "only .exr files hold further layers");
  expect_error({"render", scene, "-o", "missing/a.png"}, 4, "folder 'missing' does not exist");
  expect_error({"render", scene, "-o", "a.png", "--stats", "missing/a.json"}, 4, "--stats: missing/a.json");
  expect_error({"render", scene, "--view", "Sepia"}, 2, "'Sepia'");
  std::filesystem::create_directory(folder_ / "folder.png");
  expect_error({"render", scene, "-o", "folder.png"}, 4, "is a folder");
  EXPECT_FALSE(exists("a.png"));
}

TEST_F(Usage, UnreadableFilesExitWith4) {
  expect_error({"render", "missing.gltf"}, 4, "missing.gltf: ");
  expect_error({"info", "missing.gltf"}, 4, "missing.gltf: ");
  expect_error({"render", write_scene(), "--env", "missing.hdr"}, 4, "--env: missing.hdr: ");
}

TEST_F(Usage, InvalidScenesExitWith3) {
  TestSceneOptions broken;
  broken.accessor_count_delta = 3;
  expect_error({"render", write_scene("broken", broken)}, 3, "broken.gltf: /accessors/1");
  write_file("text.gltf", "this is no JSON");
  expect_error({"info", "text.gltf"}, 3, "text.gltf: ");
}

TEST_F(Usage, NamesUnsupportedRequiredExtensions) {
  TestSceneOptions options;
  options.light = false;
  options.extra = R"(, "extensionsUsed": ["ACME_x"], "extensionsRequired": ["ACME_x"])";
  expect_error({"render", write_scene("acme", options)}, 3, "ACME_x");
}

TEST_F(Usage, ReplacesControlCharactersOfNames) {
  const ProgramResult result = run_program({"render", "\x1b[31mred\n.gltf"}, folder_);
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_EQ(result.err.find('\x1b'), std::string::npos);
  EXPECT_EQ(result.err_lines().size(), 1U) << result.err;
}

TEST_F(Usage, HelpAndVersionGoToStandardOutput) {
  // --version opens a denoiser; an installed one ends programs with sanitizers.
  ASSERT_EQ(setenv("KINDLING_OIDN", "/nowhere", 1), 0);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"--help"}, {"render", "--help"}, {"info", "--help"}, {"--version"}, {"render", "-h", "--spp", "3"}}) {
    SCOPED_TRACE(testing::PrintToString(arguments));
    const ProgramResult result = run_program(arguments, folder_);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_NE(result.out, "");
    EXPECT_EQ(result.err, "");
  }
  const std::string help = run_program({"render", "--help"}, folder_).out;
  for (const char* flag : {"--spp", "--output", "--accel", "--env", "--crop", "--stats", "--pixel", "--view"})
    EXPECT_NE(help.find(flag), std::string::npos) << flag;
  EXPECT_TRUE(run_program({"--version"}, folder_).out.starts_with("kindling "));
  unsetenv("KINDLING_OIDN");
}

TEST_F(Usage, ListsExtensionsOfTheImporter) {
  const ProgramResult result = run_program({"info", "--list-extensions"}, folder_);
  EXPECT_EQ(result.exit_code, 0);
  std::string expected;
  for (const ExtensionSupport& extension : supported_extensions()) expected += std::string(extension.name) + "\n";
  EXPECT_EQ(result.out, expected);
  EXPECT_EQ(result.err, "");

  const ProgramResult json = run_program({"info", "--list-extensions", "--json"}, folder_);
  EXPECT_EQ(nlohmann::json::parse(json.out).size(), supported_extensions().size());
}

TEST_F(Usage, InfoPrintsTablesAndJson) {
  const std::string scene = write_scene();
  const ProgramResult tables = run_program({"info", scene}, folder_);
  EXPECT_EQ(tables.exit_code, 0) << tables.err;
  for (const char* words : {"2 in the file, 2 in the scene by 1 placed mesh", "Front", "perspective", "gray", "point",
                            "20 candela", "KHR_lights_punctual"})
    EXPECT_NE(tables.out.find(words), std::string::npos) << words << " in\n" << tables.out;

  const ProgramResult text = run_program({"info", scene, "--json"}, folder_);
  const nlohmann::json json = nlohmann::json::parse(text.out);
  EXPECT_EQ(json["triangles"], 2);
  EXPECT_EQ(json["cameras"][0]["name"], "Front");
  EXPECT_EQ(json["materials"][0]["alpha_mode"], "OPAQUE");
  EXPECT_EQ(json["lights"][0]["kind"], "point");
  EXPECT_EQ(json["bounds"]["max"][0], 0.5);
}

TEST_F(Usage, InfoPrintsLists) {
  TestSceneOptions options;
  options.light = false;
  options.extra = R"(, "extensionsUsed": ["KHR_materials_variants"], "extensions": {"KHR_materials_variants":
    {"variants": [{"name": "red"}, {"name": "blue"}]}})";
  const std::string scene = write_scene("variants", options);
  EXPECT_EQ(run_program({"info", "--list-cameras", scene}, folder_).out, "0\tFront\tperspective\n");
  EXPECT_EQ(run_program({"info", "--list-scenes", scene}, folder_).out, "0\tStage\tdefault\n");
  EXPECT_EQ(run_program({"info", "--list-variants", scene}, folder_).out, "red\nblue\n");
}

TEST_F(Usage, ClosedPipeIsNotAnError) {
  const ProgramResult result = run_program({"info", write_scene()}, folder_, Output::closed_pipe);
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_EQ(result.err, "");
}

TEST_F(Usage, FullDeviceIsAnError) {
  const ProgramResult result = run_program({"info", write_scene()}, folder_, Output::full_device);
  EXPECT_EQ(result.exit_code, 4);
  EXPECT_NE(result.err.find("kindling: error: standard output: "), std::string::npos) << result.err;
}

} // namespace
} // namespace kindling::test
