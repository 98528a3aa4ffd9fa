// A small HTTP server behind an interface: the module kindling_http, loaded when a view is served.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/result.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace kindling {

struct HttpRequest {
  std::string method; // "GET", "POST"
  std::string target; // as sent: path and query, at most HttpLimits::target_bytes
  std::string body;   // at most HttpLimits::body_bytes
  // Names in lower case. A header that is sent twice is here twice.
  std::vector<std::pair<std::string, std::string>> headers;

  // Returns the value of the first header of that name in lower case, else an empty text.
  [[nodiscard]] std::string_view header(std::string_view name) const;
};

struct HttpResponse {
  int status = 200;
  std::string content_type = "text/plain; charset=utf-8";
  std::vector<std::pair<std::string, std::string>> headers;
  std::shared_ptr<const std::string> body; // null: none
};

// Bounds on each client. A client that exceeds one is disconnected.
struct HttpLimits {
  size_t target_bytes = 1024;
  size_t request_bytes = 32 * 1024; // request line, headers and body
  size_t body_bytes = 16 * 1024;
  size_t connections = 48;  // at once; further ones are closed at once
  double request_s = 5.0;   // from the first byte of a request to its last one
  double response_s = 20.0; // for sending a response
  double idle_s = 30.0;     // between requests of a connection
};

class HttpServer {
 public:
  // Returns a refusal, decided by the headers before a body is read, or status 0.
  using Check = std::function<HttpResponse(const HttpRequest&)>;
  using Handle = std::function<HttpResponse(const HttpRequest&)>;

  virtual ~HttpServer() = default;
  // Binds to an address of this machine and a port, 0 for any free one. Returns the port. Fails
  // (input_output) with the reason of the system.
  [[nodiscard]] virtual Result<int> bind(const std::string& address, int port) = 0;
  // Serves until stop(). Functions are called on the thread of each connection. Responses with a
  // status from 400 on close their connection.
  virtual void serve(Check check, Handle handle) = 0;
  // Makes serve() return within a fraction of a second: connections are closed. Any thread.
  virtual void stop() = 0;
};

// Loads the module. Fails (render_failed) with how to get it.
[[nodiscard]] Result<std::unique_ptr<HttpServer>> make_http_server(const HttpLimits& limits = {});

// The function that the module exports under kMakeHttpServerSymbol.
using MakeHttpServer = HttpServer*(const HttpLimits&);
inline constexpr const char* kMakeHttpServerSymbol = "kindling_make_http_server";

} // namespace kindling
