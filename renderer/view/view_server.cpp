// Requests of pages.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/view_server.h"

#include "renderer/view/page_files.h"

#include <nlohmann/json.hpp>

#include <charconv>
#include <cmath>
#include <cstring>

namespace kindling {

namespace {

constexpr double kFrameWaitS = 10.0;

HttpResponse respond(int status, std::string content_type, std::string body) {
  HttpResponse response;
  response.status = status;
  response.content_type = std::move(content_type);
  response.body = std::make_shared<const std::string>(std::move(body));
  return response;
}

HttpResponse json_response(std::string body) { return respond(200, "application/json", std::move(body)); }

HttpResponse error_response(int status, const std::string& message) {
  const nlohmann::json body{{"error", message}};
  return respond(status, "application/json", body.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
}

HttpResponse file_response(const Result<SavedFrame>& saved) {
  if (!saved.ok()) return error_response(saved.error().kind == ErrorKind::usage ? 409 : 500, saved.error().message);
  HttpResponse response = respond(200, saved.value().content_type, saved.value().bytes);
  std::string name;
  for (const char c : saved.value().file_name) // as a quoted text of RFC 6266
    name +=
        c == '"' || c == '\\' || static_cast<unsigned char>(c) < ' ' || static_cast<unsigned char>(c) > '~' ? '_' : c;
  response.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + name + "\"");
  return response;
}

// Nothing but the page's own scripts runs in it, and no other page may show or read it.
void add_policy(HttpResponse& response) {
  const std::pair<const char*, const char*> policy[] = {
      {"Content-Security-Policy",
       "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; connect-src 'self'; "
       "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"},
      {"X-Content-Type-Options", "nosniff"},
      {"Referrer-Policy", "no-referrer"},
      {"Cross-Origin-Resource-Policy", "same-origin"},
      {"Cross-Origin-Opener-Policy", "same-origin"},
      {"Cache-Control", "no-store"}};
  for (const auto& [name, value] : policy) response.headers.emplace_back(name, value);
}

} // namespace

std::optional<double> query_number(std::string_view query, std::string_view name, double max) {
  while (!query.empty()) {
    const std::string_view pair = query.substr(0, query.find('&'));
    query.remove_prefix(std::min(query.size(), pair.size() + 1));
    if (!pair.starts_with(name) || pair.substr(name.size(), 1) != "=") continue;
    const std::string_view text = pair.substr(name.size() + 1);
    double value = 0.0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !(value >= 0.0 && value <= max))
      return std::nullopt;
    return value;
  }
  return std::nullopt;
}

HttpResponse ViewRequests::frame(std::string_view query) const {
  constexpr double kMaxVersion = 9e15;
  const auto after = static_cast<uint64_t>(query_number(query, "after", kMaxVersion).value_or(0.0));
  const auto image = static_cast<uint64_t>(query_number(query, "image", kMaxVersion).value_or(0.0));
  const std::shared_ptr<const SentFrame> frame = session_.wait_for_frame(after, kFrameWaitS);
  if (!frame) return {.status = 204};
  const bool has_image = frame->jpeg && frame->image != image;
  std::string body;
  body.reserve(4 + frame->header.size() + (has_image ? frame->jpeg->size() : 0));
  for (int byte = 0; byte < 4; ++byte) body += static_cast<char>((frame->header.size() >> (8 * byte)) & 0xff);
  body += frame->header;
  if (has_image) body += *frame->jpeg;
  return respond(200, "application/octet-stream", std::move(body));
}

HttpResponse ViewRequests::answer(const HttpRequest& request) const {
  const std::string_view target = gate_.inner_target(request);
  const std::string_view path = target.substr(0, target.find('?'));
  const std::string_view query = path.size() < target.size() ? target.substr(path.size() + 1) : std::string_view();
  HttpResponse response;
  if (request.method == "POST") {
    const Result<void> changed = path == "change" ? session_.change(request.body) : usage_error("POST change only");
    response = changed.ok() ? json_response("{}") : error_response(400, changed.error().message);
  } else if (request.target == "/" + gate_.token()) { // relative links of the page need the slash
    response = {.status = 301, .headers = {{"Location", "/" + gate_.token() + "/"}}};
  } else if (path == "frame") {
    response = frame(query);
  } else if (path == "scene") {
    response = json_response(session_.description());
  } else if (path == "pixel") {
    const std::optional<double> x = query_number(query, "x", 1.0), y = query_number(query, "y", 1.0);
    response = x && y ? json_response(session_.describe_pixel(V2f(static_cast<float>(*x), static_cast<float>(*y))))
                      : error_response(400, "pixel: x and y are fractions from 0 to 1");
  } else if (path == "path") {
    constexpr double kMaxSample = 1e9;
    const std::optional<double> x = query_number(query, "x", 1.0), y = query_number(query, "y", 1.0);
    const std::optional<double> sample = query_number(query, "sample", kMaxSample);
    if (!x || !y || !sample) {
      response = error_response(400, "path: x and y are fractions from 0 to 1, sample a number from 0");
    } else {
      const Result<std::string> traced =
          session_.describe_path(V2f(static_cast<float>(*x), static_cast<float>(*y)), static_cast<uint32_t>(*sample));
      response = traced.ok() ? json_response(traced.value()) : error_response(409, traced.error().message);
    }
  } else if (path == "save.png" || path == "save.exr") {
    response = file_response(session_.save(path == "save.png" ? FileKind::png : FileKind::exr));
  } else {
    response = error_response(404, "there is nothing here");
    for (const PageFile& file : page_files())
      if (file.name == (path.empty() ? "index.html" : path))
        response = respond(200, std::string(file.content_type), std::string(file.text));
  }
  add_policy(response);
  return response;
}

} // namespace kindling
