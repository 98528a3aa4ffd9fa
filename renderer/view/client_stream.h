// A client's connection with deadlines for whole requests and responses, and a bound on bytes.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/view/http_server.h"

#include <httplib.h>

#include <atomic>
#include <chrono>
#include <ctime>
#include <string>

namespace kindling {

// Timeouts of httplib begin again with each byte, so that a client that sends one byte now and then
// is never disconnected; these do not.
class ClientStream final : public httplib::Stream {
 public:
  // Does not own the socket. Both references must outlive it; `stopping` ends all waits.
  ClientStream(socket_t socket, const HttpLimits& limits, const std::atomic<bool>& stopping);

  // Waits for the first byte of the next request. False if there is none in time.
  [[nodiscard]] bool wait_for_request();
  // True if the last response had a status from 400 on: its request may not have been read.
  [[nodiscard]] bool refused() const { return refused_; }

  bool is_readable() const override; // at once
  // Older and newer versions of httplib have some of these.
  // NOLINTBEGIN(modernize-use-override)
  bool is_writable() const { return !stopping_; }
  bool wait_writable() const { return !stopping_; }
  bool wait_readable() const;
  time_t duration() const { return 0; } // for a limit of httplib's that we do not set
  // NOLINTEND(modernize-use-override)
  ssize_t read(char* bytes, size_t size) override;
  ssize_t write(const char* bytes, size_t size) override;
  void get_remote_ip_and_port(std::string& ip, int& port) const override;
  void get_local_ip_and_port(std::string& ip, int& port) const override;
  socket_t socket() const override { return socket_; }

 private:
  using Clock = std::chrono::steady_clock;
  [[nodiscard]] bool wait_until(short events, Clock::time_point deadline) const;

  socket_t socket_;
  const HttpLimits& limits_;
  const std::atomic<bool>& stopping_;
  Clock::time_point deadline_; // of the request, then of the response
  bool responding_ = false;
  bool refused_ = false;
  size_t bytes_read_ = 0; // of this request
};

} // namespace kindling
