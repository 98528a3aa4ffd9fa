// Tokens, hosts and origins.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/gate.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <system_error>
#include <utility>

#include <arpa/inet.h>
#include <sys/random.h>

namespace kindling {

namespace {

HttpResponse refusal(int status, const char* why) {
  HttpResponse response;
  response.status = status;
  response.body = std::make_shared<const std::string>(std::string("kindling view: ") + why + "\n");
  response.headers = {{"Cache-Control", "no-store"}, {"X-Content-Type-Options", "nosniff"}};
  return response;
}

std::string lower_case(std::string_view text) {
  std::string lower(text);
  for (char& c : lower) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
  return lower;
}

// Removes ":PORT".
std::string_view without_port(std::string_view host) {
  const size_t colon = host.rfind(':');
  const bool in_address = !host.empty() && host.back() == ']';
  if (colon == std::string_view::npos || in_address) return host;
  const std::string_view port = host.substr(colon + 1);
  const bool digits = !port.empty() && port.size() <= 5 &&
                      std::all_of(port.begin(), port.end(), [](char c) { return c >= '0' && c <= '9'; });
  return digits ? host.substr(0, colon) : host;
}

std::string_view without_brackets(std::string_view host) {
  const bool brackets = host.size() >= 2 && host.front() == '[' && host.back() == ']';
  return brackets ? host.substr(1, host.size() - 2) : host;
}

size_t count_of(const HttpRequest& request, std::string_view name) {
  return static_cast<size_t>(std::count_if(request.headers.begin(), request.headers.end(),
                                           [&](const auto& header) { return header.first == name; }));
}

bool is_loopback(std::string_view host) {
  return host == "localhost" || host == "::1" || (host.starts_with("127.") && is_ip_address(host));
}

} // namespace

std::string_view HttpRequest::header(std::string_view name) const {
  for (const auto& [key, value] : headers)
    if (key == name) return value;
  return {};
}

std::string make_token() {
  std::array<uint8_t, 16> bytes{};
  size_t filled = 0;
  while (filled < bytes.size()) {
    const ssize_t count = getrandom(bytes.data() + filled, bytes.size() - filled, 0);
    if (count > 0)
      filled += static_cast<size_t>(count);
    else if (errno != EINTR)
      throw std::system_error(errno, std::generic_category(), "no random numbers from the system");
  }
  std::string token;
  for (const uint8_t byte : bytes) token += fmt::format("{:02x}", byte);
  return token;
}

bool is_token(std::string_view sent, std::string_view token) {
  unsigned difference = sent.size() == token.size() ? 0U : 1U;
  for (size_t i = 0; i < sent.size(); ++i)
    difference |= static_cast<unsigned char>(sent[i]) ^ static_cast<unsigned char>(token[i % token.size()]);
  return difference == 0;
}

bool is_ip_address(std::string_view text) {
  const std::string address(without_brackets(text));
  std::array<uint8_t, sizeof(in6_addr)> bytes{};
  return inet_pton(AF_INET, address.c_str(), bytes.data()) == 1 ||
         inet_pton(AF_INET6, address.c_str(), bytes.data()) == 1;
}

Gate::Gate(std::string token, std::string listen, std::string host_name)
    : token_(std::move(token)), names_{lower_case(listen), lower_case(host_name)},
      loopback_(is_loopback(lower_case(without_brackets(listen)))) {}

bool Gate::is_our_host(std::string_view host) const {
  const std::string lower = lower_case(without_port(host));
  const std::string_view name = without_brackets(lower);
  if (is_loopback(name)) return true;
  if (loopback_ || name.empty()) return false;
  return is_ip_address(name) || std::find(names_.begin(), names_.end(), name) != names_.end();
}

HttpResponse Gate::check(const HttpRequest& request) const {
  if (request.method != "GET" && request.method != "POST") return refusal(405, "the methods are GET and POST");
  if (request.target.size() > HttpLimits().target_bytes) return refusal(414, "the address is too long");
  if (count_of(request, "host") != 1 || !is_our_host(request.header("host")))
    return refusal(421, "this is another host; open the link as it was printed, by 127.0.0.1 or localhost");
  const std::string_view origin = request.header("origin");
  const std::string own_origin = "http://" + lower_case(request.header("host"));
  if (count_of(request, "origin") > 1 || (!origin.empty() && lower_case(origin) != own_origin))
    return refusal(403, "requests of other pages are not answered");
  const bool foreign =
      request.header("sec-fetch-site") == "cross-site" || request.header("sec-fetch-site") == "same-site";
  if (foreign && request.header("sec-fetch-mode") != "navigate")
    return refusal(403, "requests of other pages are not answered");
  if (count_of(request, "transfer-encoding") > 0 || count_of(request, "content-encoding") > 0)
    return refusal(411, "a body must have a Content-Length and no encoding");
  if (request.method == "POST" &&
      (count_of(request, "content-length") != 1 || !request.header("content-type").starts_with("application/json")))
    return refusal(415, "a body must be JSON with a Content-Length");
  const std::string_view path = std::string_view(request.target).substr(0, request.target.find('?'));
  if (!path.starts_with('/')) return refusal(400, "this is no path");
  const std::string_view first = path.substr(1, path.find('/', 1) - 1);
  if (!is_token(first, token_))
    return refusal(403, "the link is not valid; each start of kindling view prints a new one");
  return {.status = 0};
}

std::string_view Gate::inner_target(const HttpRequest& request) const {
  const std::string_view target = request.target;
  return target.substr(std::min(target.size(), token_.size() + 2));
}

} // namespace kindling
