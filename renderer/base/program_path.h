// The path of the running program, beside which its modules and libraries lie.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <system_error>

#include <sys/auxv.h>

namespace kindling {

// Returns the program's file with all links followed, or where /proc is not mounted the path by
// which it was started; empty if the system tells neither.
[[nodiscard]] inline std::filesystem::path program_path() {
  std::error_code code;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", code);
  if (!code) return program;
  const auto* const started = reinterpret_cast<const char*>(getauxval(AT_EXECFN));
  return started == nullptr ? std::filesystem::path() : std::filesystem::absolute(started, code);
}

} // namespace kindling
