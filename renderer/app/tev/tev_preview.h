// The growing image of a render in the image viewer tev.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/app/tev/tev_connection.h"
#include "renderer/film/film.h"

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

namespace kindling::app {

// Sends tiles as their blocks are rendered, at most ten times in a second each, by a thread of its
// own: a slow viewer gets fewer images and does not delay the render. If the viewer goes away, one
// warning reports it and the render continues.
class TevPreview {
 public:
  // `warn` is called at most once, by another thread.
  TevPreview(TevConnection connection, std::function<void(const std::string&)> warn);
  ~TevPreview();
  TevPreview(const TevPreview&) = delete;
  TevPreview& operator=(const TevPreview&) = delete;

  // Starts an image of this size, of which the pixels of `crop` will come.
  void start_image(const std::string& name, const V2i& size_px, const PixelRect& crop);
  // Takes the means of a block's pixels. Called by the thread that owns the block; several threads
  // may call it at once.
  void take_block(const PixelRect& block, const Film& film);
  // Sends the whole image and waits until the viewer has it, or is gone. No block may be taken
  // meanwhile.
  void finish_image(const Film& film);

 private:
  static constexpr int kTileSize = 32;

  void run();
  // Sends the tiles that have changed. `lock` holds mutex_, and is released while sending.
  void send_changes(std::unique_lock<std::mutex>& lock);
  [[nodiscard]] PixelRect tile_rect(size_t tile) const;

  TevConnection connection_;
  std::function<void(const std::string&)> warn_;
  std::mutex mutex_;
  std::condition_variable wake_, sent_;
  // Guarded by mutex_.
  std::string name_;
  V2i size_px_{0, 0};
  PixelRect crop_;
  int tiles_x_ = 0;
  std::vector<float> rgba_; // of the crop
  std::vector<uint8_t> changed_;
  bool create_ = false;  // the image is not made yet
  bool changes_ = false; // some tile has changed
  bool hurry_ = false;   // do not wait for more changes
  bool sending_ = false;
  bool ends_ = false;
  bool lost_ = false; // the viewer is gone
  std::thread thread_;
};

} // namespace kindling::app
