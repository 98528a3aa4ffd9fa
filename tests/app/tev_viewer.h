// A stand-in for the image viewer tev: it listens, and builds images from messages.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <thread>
#include <vector>

namespace kindling::test {

class TevViewer {
 public:
  // `bytes_taken`: closes the connection after so many.
  explicit TevViewer(size_t bytes_taken = SIZE_MAX);
  ~TevViewer();
  TevViewer(const TevViewer&) = delete;
  TevViewer& operator=(const TevViewer&) = delete;

  [[nodiscard]] std::string address() const; // "127.0.0.1:PORT"

  struct Image {
    int width = 0;
    int height = 0;
    std::vector<std::string> channels;
    std::vector<float> values; // interleaved, rows from the top
    int updates = 0;
  };
  // Waits until the sender has closed the connection. Unknown or damaged messages are errors.
  const std::map<std::string, Image>& finish();
  [[nodiscard]] const std::vector<std::string>& errors() const { return errors_; }

 private:
  void receive(size_t bytes_taken);
  void take_message(const std::vector<std::byte>& bytes);

  int listening_ = -1;
  uint16_t port_ = 0;
  std::thread thread_;
  std::map<std::string, Image> images_;
  std::vector<std::string> errors_;
};

} // namespace kindling::test
