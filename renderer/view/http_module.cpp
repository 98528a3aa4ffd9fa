// The module kindling_http: cpp-httplib parses requests, a stream of ours bounds time and sizes.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/client_stream.h"
#include "renderer/view/http_server.h"

#include <fmt/format.h>
#include <httplib.h>

#include <atomic>
#include <cerrno>
#include <condition_variable>
#include <cstring>
#include <mutex>
#include <thread>
#include <utility>

#include <sys/socket.h>
#include <unistd.h>

namespace kindling {

namespace {

// The result of httplib's queues: nothing in older versions, later whether there was room.
using Enqueued = decltype(std::declval<httplib::TaskQueue&>().enqueue({}));

// A thread for each connection. Those beyond the limit are refused on the thread that accepts.
class ConnectionThreads final : public httplib::TaskQueue {
 public:
  ConnectionThreads(size_t limit, std::atomic<bool>& refuses) : limit_(limit), refuses_(refuses) {}

  Enqueued enqueue(std::function<void()> connection) override {
    if (!start(connection)) {
      refuses_ = true;
      connection();
      refuses_ = false;
    }
    return static_cast<Enqueued>(true);
  }

  void shutdown() override {
    std::unique_lock lock(mutex_);
    ended_.wait(lock, [this] { return running_ == 0; });
  }

 private:
  // Returns false if there are too many connections.
  bool start(const std::function<void()>& connection) {
    const std::lock_guard lock(mutex_);
    if (running_ >= limit_) return false;
    ++running_;
    std::thread([this, connection] {
      connection();
      const std::lock_guard ending(mutex_);
      --running_;
      ended_.notify_all();
    }).detach();
    return true;
  }

  std::mutex mutex_;
  std::condition_variable ended_;
  size_t running_ = 0;
  size_t limit_;
  std::atomic<bool>& refuses_; // read by the thread that accepts
};

HttpRequest to_request(const httplib::Request& request) {
  HttpRequest result{.method = request.method, .target = request.target, .body = request.body};
  for (const auto& [name, value] : request.headers) {
    std::string lower = name;
    for (char& c : lower) c = static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
    result.headers.emplace_back(std::move(lower), value);
  }
  return result;
}

void fill(httplib::Response& response, const HttpResponse& from) {
  response.status = from.status;
  for (const auto& [name, value] : from.headers) response.set_header(name, value);
  if (from.body) response.set_content(from.body->data(), from.body->size(), from.content_type);
}

class HttplibServer final : public HttpServer, private httplib::Server {
 public:
  explicit HttplibServer(const HttpLimits& limits) : limits_(limits) {
    set_payload_max_length(limits.body_bytes);
    set_keep_alive_max_count(1U << 30); // by our loop
    new_task_queue = [this] { return new ConnectionThreads(limits_.connections, refuses_); };
  }

  Result<int> bind(const std::string& address, int port) override {
    errno = 0;
    int bound = port;
    if (port == 0)
      bound = bind_to_any_port(address);
    else if (!bind_to_port(address, port))
      bound = -1;
    if (bound > 0) return bound;
    const std::string reason = errno != 0 ? std::strerror(errno) : "it is no address of this machine";
    return Error{ErrorKind::input_output, fmt::format("cannot listen on {} port {}: {}", address, port, reason)};
  }

  void serve(Check check, Handle handle) override {
    set_pre_routing_handler([check = std::move(check)](const httplib::Request& request, httplib::Response& response) {
      const HttpResponse refusal = check(to_request(request));
      if (refusal.status == 0) return HandlerResponse::Unhandled;
      fill(response, refusal);
      return HandlerResponse::Handled;
    });
    const auto answer = [handle = std::move(handle)](const httplib::Request& request, httplib::Response& response) {
      fill(response, handle(to_request(request)));
    };
    Get("/.*", answer);
    Post("/.*", answer);
    set_exception_handler(
        [](const httplib::Request&, httplib::Response& response, const std::exception_ptr&) { response.status = 500; });
    acceptor_ = std::this_thread::get_id();
    if (!stopping_) listen_after_bind();
  }

  void stop() override {
    stopping_ = true;
    httplib::Server::stop();
  }

 private:
  // Called by httplib for each connection, on a thread of ConnectionThreads.
  bool process_and_close_socket(socket_t socket) override {
    if (!refuses_ || std::this_thread::get_id() != acceptor_) {
      ClientStream stream(socket, limits_, stopping_);
      bool closed = false;
      while (!closed && !stopping_ && stream.wait_for_request()) {
        if (!answer(stream, closed) || stream.refused()) break;
      }
    }
    ::shutdown(socket, SHUT_RDWR);
    ::close(socket);
    return true;
  }

  // Later versions of httplib take the addresses of both ends, which we do not use.
  bool answer(auto& stream, bool& closed) {
    if constexpr (requires { process_request(stream, false, closed, nullptr); })
      return process_request(stream, false, closed, nullptr);
    else
      return process_request(stream, std::string(), 0, std::string(), 0, false, closed, nullptr);
  }

  HttpLimits limits_;
  std::atomic<bool> stopping_{false};
  std::atomic<bool> refuses_{false};
  std::thread::id acceptor_;
};

} // namespace

} // namespace kindling

extern "C" __attribute__((visibility("default"))) kindling::HttpServer*
kindling_make_http_server(const kindling::HttpLimits& limits) {
  return new kindling::HttplibServer(limits);
}
