// A TCP connection to the image viewer tev.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/tev/tev_address.h"
#include "renderer/base/result.h"

#include <cstddef>
#include <span>

namespace kindling::app {

class TevConnection {
 public:
  // Waits at most three seconds for each address of the host. Fails (input_output).
  [[nodiscard]] static Result<TevConnection> open(const TevAddress& address);
  ~TevConnection();
  TevConnection(TevConnection&& other) noexcept;
  TevConnection(const TevConnection&) = delete;
  TevConnection& operator=(const TevConnection&) = delete;

  // Sends all bytes. False if the viewer is gone, or has taken nothing for five seconds.
  [[nodiscard]] bool send(std::span<const std::byte> bytes);

 private:
  explicit TevConnection(int socket) : socket_(socket) {}
  int socket_ = -1;
};

} // namespace kindling::app
