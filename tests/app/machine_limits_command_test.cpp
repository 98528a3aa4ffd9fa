// Renders under small stack limits, without temporary files, and where signals are ignored.
// signals.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <signal.h>
#include <unistd.h>

#include <string>
#include <vector>

namespace kindling::test {
namespace {

using std::chrono::seconds;

class MachineLimits : public SceneFolder {};

// As nohup ignores it.
TEST_F(MachineLimits, IgnoredHangUpStaysIgnored) {
  Program program({"render", write_scene(), "--spp", "1000000", "--size", "64x64", "-o", "a.png", "--progress", "json"},
                  folder_, Output::pipe, "trap '' HUP");
  ASSERT_TRUE(program.wait_for_error_text("\"phase\":\"render\"", seconds(60)));
  program.signal(SIGHUP);
  usleep(300000);
  program.signal(SIGINT);
  EXPECT_EQ(program.finish(seconds(60)).exit_code, 130);
}

// Threads of the program have enough stack under any limit; other limits are not its concern.
TEST_F(MachineLimits, SmallStackLimitsAreNoCrash) {
  const std::string scene = write_scene();
  for (const char* limit : {"384", "128"})
    for (const std::vector<std::string>& command :
         {std::vector<std::string>{"render", scene, "--spp", "4", "--size", "32x32", "-o", "a.png", "--accel",
                                   "kdtree"},
          {"render", scene, "--spp", "4", "--size", "32x32", "-o", "a.exr", "--accel", "embree"},
          {"info", scene}}) {
      Program program(command, folder_, Output::pipe, std::string("ulimit -s ") + limit);
      const ProgramResult result = program.finish();
      EXPECT_EQ(result.exit_code, 0) << limit << " " << command[0] << " " << result.err;
    }
}

// A second signal, and SIGTERM, reach a render in a thread of its own, too.
TEST_F(MachineLimits, SmallStackLimitsKeepSignals) {
  Program program({"render", write_scene(), "--spp", "1000000", "--size", "64x64", "-o", "a.png", "--progress", "json"},
                  folder_, Output::pipe, "ulimit -s 384");
  ASSERT_TRUE(program.wait_for_error_text("\"phase\":\"render\"", seconds(60)));
  program.signal(SIGTERM);
  EXPECT_EQ(program.finish(seconds(60)).exit_code, 143);
  EXPECT_TRUE(exists("a.png"));
}

// A node of a farm without its disk for temporary files fails; the scene is not to blame (3), which
// would stop all nodes.
TEST_F(MachineLimits, MissingTemporaryFolderIsNoFaultOfTheScene) {
  const auto render = [&](const std::string& temporary, std::vector<std::string> more) {
    std::vector<std::string> words{"render", KINDLING_SCENES "/interior.glb", "--spp", "1", "--size", "8x8", "-q"};
    words.insert(words.end(), more.begin(), more.end());
    Program program(words, folder_, Output::pipe, "export TMPDIR=" + temporary);
    return program.finish();
  };
  for (const char* temporary : {"/no/such/folder", "/dev/null", "/proc"}) {
    const ProgramResult result = render(temporary, {"-o", "a.png", "--texture-memory", "64K"});
    EXPECT_EQ(result.exit_code, 4) << result.err;
    EXPECT_NE(result.err.find("textures on disk: no temporary folder in '" + std::string(temporary) + "': "),
              std::string::npos)
        << result.err;
    EXPECT_EQ(result.err_lines().size(), 1U) << result.err;
  }
  EXPECT_EQ(render("/no/such/folder", {"-o", "-"}).exit_code, 0);
}

} // namespace
} // namespace kindling::test
