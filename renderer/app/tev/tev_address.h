// The address at which the image viewer tev listens.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <string>
#include <string_view>

namespace kindling::app {

struct TevAddress {
  std::string host = "127.0.0.1"; // a name, an IPv4 or an IPv6 address
  std::string port = "14158";     // tev's own default
};

// "HOST", "HOST:PORT", "[IPV6]" or "[IPV6]:PORT". Fails (usage).
[[nodiscard]] Result<TevAddress> parse_tev_address(std::string_view text);

} // namespace kindling::app
