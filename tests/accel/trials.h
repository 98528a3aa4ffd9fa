// Numbers of seeds and rays of a test, which environment variables can override.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdlib>

namespace kindling::accel::testing {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool kSanitized = true;
#elif defined(__has_feature)
inline constexpr bool kSanitized = __has_feature(address_sanitizer) || __has_feature(thread_sanitizer);
#else
inline constexpr bool kSanitized = false;
#endif

[[nodiscard]] inline size_t number_from_environment(const char* name, size_t otherwise) {
  const char* text = std::getenv(name);
  return text == nullptr ? otherwise : std::strtoul(text, nullptr, 10);
}

// Returns the value of the variable `name`, else `count`, or an eighth of it under a sanitizer.
// There rays take ten times as long, and memory errors show in few rays as well as in many; the
// answers are checked in other builds.
[[nodiscard]] inline size_t trials(const char* name, size_t count) {
  return number_from_environment(name, kSanitized ? (count + 7) / 8 : count);
}

} // namespace kindling::accel::testing
