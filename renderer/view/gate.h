// Decides which requests are answered: token, host, origin, method and sizes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/view/http_server.h"

#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Returns 32 random hexadecimal digits of the system's generator.
[[nodiscard]] std::string make_token();

// Compares in a time that depends on the length of `sent` only.
[[nodiscard]] bool is_token(std::string_view sent, std::string_view token);

// Links have the form http://HOST:PORT/TOKEN/, so that a page needs no cookie, which all ports of a
// host would share.
class Gate {
 public:
  // `listen`: the address that the server is bound to. On a loopback address, requests must name a
  // loopback host, by any port, so that a tunnel of ssh works and a name that an attacker's DNS
  // points here does not. Elsewhere they may name any IP address, this host, or `listen`.
  Gate(std::string token, std::string listen, std::string host_name);

  // Returns a refusal, or status 0. A page of another origin is refused, whatever it knows.
  [[nodiscard]] HttpResponse check(const HttpRequest& request) const;
  // Returns the part of the target after "/TOKEN/", query included, of a request that passed.
  [[nodiscard]] std::string_view inner_target(const HttpRequest& request) const;
  [[nodiscard]] const std::string& token() const { return token_; }

 private:
  [[nodiscard]] bool is_our_host(std::string_view host) const;

  std::string token_;
  std::vector<std::string> names_; // lower case
  bool loopback_ = true;
};

// Returns whether `text` is an IPv4 or IPv6 address, the latter with or without brackets.
[[nodiscard]] bool is_ip_address(std::string_view text);

} // namespace kindling
