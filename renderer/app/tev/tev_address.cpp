// Parsing of HOST:PORT.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/tev/tev_address.h"

#include <fmt/format.h>

namespace kindling::app {

namespace {

bool is_port(std::string_view text) {
  if (text.empty() || text.size() > 5 || text.find_first_not_of("0123456789") != std::string_view::npos) return false;
  const int number = std::stoi(std::string(text));
  return number >= 1 && number <= 65535;
}

} // namespace

Result<TevAddress> parse_tev_address(std::string_view text) {
  TevAddress address;
  const bool bracketed = !text.empty() && text.front() == '[';
  const size_t host_end = bracketed ? text.find(']') : text.find(':');
  std::string_view rest;
  if (bracketed) {
    address.host = std::string(host_end == std::string_view::npos ? "" : text.substr(1, host_end - 1));
    rest = host_end == std::string_view::npos ? "" : text.substr(host_end + 1);
  } else {
    address.host = std::string(text.substr(0, host_end));
    rest = host_end == std::string_view::npos ? "" : text.substr(host_end);
  }
  if (!rest.empty()) address.port = std::string(rest.substr(1));
  if (address.host.empty() || (!rest.empty() && rest.front() != ':') || !is_port(address.port))
    return usage_error(fmt::format("'{}' is not an address; use HOST or HOST:PORT with a port from 1 to 65535, and "
                                   "brackets around an IPv6 address, such as [::1]:14158",
                                   text));
  return address;
}

} // namespace kindling::app
