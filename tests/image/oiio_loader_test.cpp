// Tests of the module loader: search order, and errors that list the searched folders.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/image/oiio_loader.h"

#include <gtest/gtest.h>

#include <fstream>
#include <thread>

#include <unistd.h>

namespace kindling::image_detail {
namespace {

namespace fs = std::filesystem;

TEST(OiioLoader, LoadsOnceForAllThreads) {
  std::vector<const Result<OiioModule>*> modules(4);
  {
    std::vector<std::jthread> threads;
    for (auto& module : modules) threads.emplace_back([&module] { module = &oiio_module(); });
  }
  for (const auto* module : modules) {
    ASSERT_TRUE(module->ok()) << module->error().message;
    EXPECT_EQ(module, modules[0]);
    EXPECT_NE(module->value().write_tiled, nullptr);
  }
}

TEST(OiioLoader, SearchesBesideProgramFirst) {
  const std::vector<fs::path> folders = oiio_module_folders();
  ASSERT_EQ(folders.size(), 4U);
  EXPECT_EQ(folders[0], fs::read_symlink("/proc/self/exe").parent_path());
  EXPECT_EQ(folders[1].filename(), "kindling");
  EXPECT_EQ(folders[3], fs::path(KINDLING_BINARY_DIR));
}

TEST(OiioLoader, ReportsSearchedFolders) {
  const std::vector<fs::path> folders{"/no/such", "/nor/this"};
  const Result<OiioModule> module = load_oiio_module(folders);
  ASSERT_FALSE(module.ok());
  EXPECT_EQ(module.error().message, "the OpenImageIO module kindling_oiio.so was not found in /no/such, /nor/this");
  EXPECT_EQ(module.error().kind, ErrorKind::input_output);
}

TEST(OiioLoader, RefusesInvalidModule) {
  const fs::path folder = fs::path(testing::TempDir()) / ("kindling_oiio_loader" + std::to_string(getpid()));
  fs::create_directories(folder);
  std::ofstream(folder / "kindling_oiio.so") << "no library";
  const Result<OiioModule> module = load_oiio_module(std::vector<fs::path>{folder});
  fs::remove_all(folder);
  ASSERT_FALSE(module.ok());
  EXPECT_NE(module.error().message.find("the OpenImageIO module cannot be loaded: "), std::string::npos);
  EXPECT_EQ(module.error().message.find('\n'), std::string::npos);
}

} // namespace
} // namespace kindling::image_detail
