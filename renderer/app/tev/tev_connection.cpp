// Connecting to tev and sending, with deadlines.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/tev/tev_connection.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <netdb.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <utility>

namespace kindling::app {

namespace {

constexpr int kConnectMs = 3000;
constexpr int kSendMs = 5000;

// Waits until data can be sent. False after the time.
bool wait_to_send(int socket, int milliseconds) {
  pollfd waited{.fd = socket, .events = POLLOUT, .revents = 0};
  for (;;) {
    const int ready = poll(&waited, 1, milliseconds);
    if (ready < 0 && errno == EINTR) continue;
    return ready > 0;
  }
}

// Returns 0 or the number of the error.
int connect_within(int socket, const addrinfo& address) {
  if (connect(socket, address.ai_addr, address.ai_addrlen) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (!wait_to_send(socket, kConnectMs)) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  return getsockopt(socket, SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
}

Error no_viewer(const TevAddress& address, const std::string& reason) {
  return {ErrorKind::input_output, fmt::format("--tev: no image viewer tev answers at {} port {}: {}; start tev there "
                                               "before the render, or name another address with --tev-host",
                                               address.host, address.port, reason)};
}

} // namespace

Result<TevConnection> TevConnection::open(const TevAddress& address) {
  addrinfo hints{};
  hints.ai_family = AF_UNSPEC;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  if (const int error = getaddrinfo(address.host.c_str(), address.port.c_str(), &hints, &found); error != 0)
    return no_viewer(address, gai_strerror(error));
  const std::unique_ptr<addrinfo, decltype(&freeaddrinfo)> addresses(found, &freeaddrinfo);
  int error = ECONNREFUSED;
  for (const addrinfo* candidate = addresses.get(); candidate != nullptr; candidate = candidate->ai_next) {
    const int socket = ::socket(candidate->ai_family, candidate->ai_socktype | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (socket < 0) {
      error = errno;
      continue;
    }
    TevConnection connection(socket);
    error = connect_within(socket, *candidate);
    if (error == 0) return connection;
  }
  return no_viewer(address, std::strerror(error));
}

TevConnection::TevConnection(TevConnection&& other) noexcept : socket_(std::exchange(other.socket_, -1)) {}

TevConnection::~TevConnection() {
  if (socket_ >= 0) close(socket_);
}

bool TevConnection::send(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t sent = ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (sent > 0) {
      bytes = bytes.subspan(static_cast<size_t>(sent));
    } else if (sent < 0 && errno != EINTR) {
      if ((errno != EAGAIN && errno != EWOULDBLOCK) || !wait_to_send(socket_, kSendMs)) return false;
    }
  }
  return true;
}

} // namespace kindling::app
