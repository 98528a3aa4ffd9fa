// Reads and writes a socket without blocking, and waits in short steps.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/view/client_stream.h"

#include <algorithm>
#include <cerrno>
#include <string_view>

#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>

namespace kindling {

namespace {

constexpr std::chrono::milliseconds kStep(100); // in which the end of the server is noticed

std::chrono::steady_clock::duration seconds(double s) {
  return std::chrono::duration_cast<std::chrono::steady_clock::duration>(std::chrono::duration<double>(s));
}

} // namespace

ClientStream::ClientStream(socket_t socket, const HttpLimits& limits, const std::atomic<bool>& stopping)
    : socket_(socket), limits_(limits), stopping_(stopping) {
  const int on = 1;
  setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof(on));
}

bool ClientStream::wait_until(short events, Clock::time_point deadline) const {
  while (!stopping_) {
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now());
    if (left.count() <= 0) return false;
    pollfd waiting{socket_, events, 0};
    const int ready = poll(&waiting, 1, static_cast<int>(std::min(left, kStep).count()));
    if (ready > 0) return true; // or hung up, which read and write find
    if (ready < 0 && errno != EINTR) return false;
  }
  return false;
}

bool ClientStream::wait_for_request() {
  if (!wait_until(POLLIN, Clock::now() + seconds(limits_.idle_s))) return false;
  deadline_ = Clock::now() + seconds(limits_.request_s);
  responding_ = refused_ = false;
  bytes_read_ = 0;
  return true;
}

bool ClientStream::is_readable() const {
  pollfd waiting{socket_, POLLIN, 0};
  return poll(&waiting, 1, 0) > 0;
}

bool ClientStream::wait_readable() const { return wait_until(POLLIN, deadline_); }

ssize_t ClientStream::read(char* bytes, size_t size) {
  const size_t wanted = std::min(size, limits_.request_bytes - bytes_read_);
  if (wanted == 0) return -1;
  for (;;) {
    if (!wait_until(POLLIN, deadline_)) return -1;
    const ssize_t count = recv(socket_, bytes, wanted, MSG_DONTWAIT);
    if (count >= 0) {
      bytes_read_ += static_cast<size_t>(count);
      return count;
    }
    if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR) return -1;
  }
}

ssize_t ClientStream::write(const char* bytes, size_t size) {
  if (!responding_) {
    responding_ = true;
    deadline_ = Clock::now() + seconds(limits_.response_s);
    constexpr size_t kStatus = std::string_view("HTTP/1.1 ").size();
    refused_ = size > kStatus && bytes[kStatus] >= '4';
  }
  size_t sent = 0;
  while (sent < size) {
    if (!wait_until(POLLOUT, deadline_)) return -1;
    const ssize_t count = send(socket_, bytes + sent, size - sent, MSG_DONTWAIT | MSG_NOSIGNAL);
    if (count >= 0)
      sent += static_cast<size_t>(count);
    else if (errno != EAGAIN && errno != EWOULDBLOCK && errno != EINTR)
      return -1;
  }
  return static_cast<ssize_t>(size);
}

// No handler asks for addresses.
void ClientStream::get_remote_ip_and_port(std::string&, int&) const {}
void ClientStream::get_local_ip_and_port(std::string&, int&) const {}

} // namespace kindling
