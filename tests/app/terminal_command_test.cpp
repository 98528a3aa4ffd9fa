// Control characters of names and files never reach a terminal.
// SPDX-License-Identifier: Apache-2.0
#include "tests/app/run_program.h"
#include "tests/app/test_scene.h"

#include <cstdlib>
#include <string>

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

namespace kindling::test {
namespace {

// Runs the program with a terminal as standard output, and returns all that it prints there.
std::string run_on_terminal(const std::vector<std::string>& arguments, const std::filesystem::path& folder) {
  const int terminal = posix_openpt(O_RDWR | O_NOCTTY);
  if (terminal < 0 || grantpt(terminal) != 0 || unlockpt(terminal) != 0) return "no terminal";
  const std::string name = ptsname(terminal);
  const int other = open(name.c_str(), O_RDWR | O_NOCTTY); // keeps the text until it is read
  Program program(arguments, folder, Output::pipe, "exec > " + name);
  const ProgramResult result = program.finish();
  EXPECT_EQ(result.exit_code, 0) << result.err;
  std::string text;
  pollfd waiting{terminal, POLLIN, 0};
  while (poll(&waiting, 1, 100) > 0) {
    char buffer[4096];
    const ssize_t count = read(terminal, buffer, sizeof buffer);
    if (count <= 0) break;
    text.append(buffer, static_cast<size_t>(count));
  }
  close(other);
  close(terminal);
  return text;
}

class TerminalCommand : public SceneFolder {};

TEST_F(TerminalCommand, NamesOfImagesAreShownWithoutControlCharacters) {
  const std::vector<std::string> words{"render", write_scene(), "--size", "8x8",
                                       "--spp",  "1",           "-o",     "red\x1b[31m\x9bx.png"};
  EXPECT_EQ(run_on_terminal(words, folder_), "red?[31m?x.png\r\n");
  EXPECT_EQ(run_program(words, folder_).out, "red\x1b[31m\x9bx.png\n"); // scripts get the name itself
}

TEST_F(TerminalCommand, MessagesHaveNoControlCharacters) {
  const ProgramResult missing = run_program({"render", "no\x1b]0;x\x07\x9b.glb", "-o", "\x1b.png"}, folder_);
  EXPECT_EQ(missing.exit_code, 4);
  EXPECT_EQ(missing.err.find_first_of("\x1b\x07\x9b"), std::string::npos);
  std::filesystem::copy_file(folder_ / write_scene(), folder_ / "a\x1b[2J.gltf");
  const ProgramResult plain =
      run_program({"render", "a\x1b[2J.gltf", "--size", "8x8", "--spp", "1", "-o", "\x1b.png"}, folder_);
  EXPECT_EQ(plain.exit_code, 0);
  EXPECT_EQ(plain.err.find('\x1b'), std::string::npos) << plain.err;
}

} // namespace
} // namespace kindling::test
