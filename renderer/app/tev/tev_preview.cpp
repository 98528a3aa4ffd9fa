// Collecting rendered blocks, and sending them as tiles by another thread.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/tev/tev_preview.h"

#include "renderer/app/tev/tev_packets.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <utility>

namespace kindling::app {

namespace {

constexpr std::chrono::milliseconds kInterval{100};

} // namespace

TevPreview::TevPreview(TevConnection connection, std::function<void(const std::string&)> warn)
    : connection_(std::move(connection)), warn_(std::move(warn)), thread_([this] { run(); }) {}

TevPreview::~TevPreview() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  wake_.notify_all();
  thread_.join();
}

void TevPreview::start_image(const std::string& name, const V2i& size_px, const PixelRect& crop) {
  const std::lock_guard lock(mutex_);
  name_ = name;
  size_px_ = size_px;
  crop_ = crop;
  tiles_x_ = (crop.width() + kTileSize - 1) / kTileSize;
  const int tiles_y = (crop.height() + kTileSize - 1) / kTileSize;
  rgba_.assign(static_cast<size_t>(crop.pixel_count()) * 4, 0.0f);
  changed_.assign(static_cast<size_t>(tiles_x_) * static_cast<size_t>(tiles_y), 0);
  create_ = changes_ = true;
  wake_.notify_all();
}

void TevPreview::take_block(const PixelRect& block, const Film& film) {
  const std::vector<float> rgba = film.resolve_rgba(block);
  const std::lock_guard lock(mutex_);
  if (lost_) return;
  const auto row = static_cast<size_t>(block.width()) * 4;
  for (int y = block.min.y; y < block.max.y; ++y) {
    const size_t to = (static_cast<size_t>(y - crop_.min.y) * static_cast<size_t>(crop_.width()) +
                       static_cast<size_t>(block.min.x - crop_.min.x)) *
                      4;
    std::copy_n(rgba.begin() + static_cast<ptrdiff_t>(row * static_cast<size_t>(y - block.min.y)), row,
                rgba_.begin() + static_cast<ptrdiff_t>(to));
  }
  // A block may lie in up to four tiles of a crop that is not on the grid of blocks.
  for (const int y : {block.min.y, block.max.y - 1})
    for (const int x : {block.min.x, block.max.x - 1})
      changed_[static_cast<size_t>((y - crop_.min.y) / kTileSize * tiles_x_ + (x - crop_.min.x) / kTileSize)] = 1;
  if (!std::exchange(changes_, true)) wake_.notify_all();
}

void TevPreview::finish_image(const Film& film) {
  take_block(film.crop(), film);
  std::unique_lock lock(mutex_);
  std::fill(changed_.begin(), changed_.end(), uint8_t{1});
  changes_ = hurry_ = true;
  wake_.notify_all();
  sent_.wait(lock, [this] { return lost_ || (!changes_ && !sending_); });
  hurry_ = false;
}

PixelRect TevPreview::tile_rect(size_t tile) const {
  const V2i first = crop_.min + V2i(static_cast<int>(tile) % tiles_x_, static_cast<int>(tile) / tiles_x_) * kTileSize;
  return {first, {std::min(first.x + kTileSize, crop_.max.x), std::min(first.y + kTileSize, crop_.max.y)}};
}

void TevPreview::run() {
  std::unique_lock lock(mutex_);
  while (!lost_) {
    wake_.wait(lock, [this] { return ends_ || changes_; });
    if (ends_) return;
    send_changes(lock);
    sent_.notify_all();
    if (lost_) break;
    wake_.wait_for(lock, kInterval, [this] { return ends_ || hurry_; });
  }
  lock.unlock();
  warn_("--tev: the image viewer is gone; the render continues without it");
}

void TevPreview::send_changes(std::unique_lock<std::mutex>& lock) {
  changes_ = false;
  sending_ = true;
  std::vector<std::vector<std::byte>> messages;
  if (std::exchange(create_, false)) messages.push_back(tev_create_image(name_, size_px_));
  for (size_t tile = 0; tile < changed_.size(); ++tile) {
    if (!std::exchange(changed_[tile], uint8_t{0})) continue;
    const PixelRect rect = tile_rect(tile);
    std::vector<float> rgba;
    rgba.reserve(static_cast<size_t>(rect.pixel_count()) * 4);
    for (int y = rect.min.y; y < rect.max.y; ++y) {
      const size_t first = (static_cast<size_t>(y - crop_.min.y) * static_cast<size_t>(crop_.width()) +
                            static_cast<size_t>(rect.min.x - crop_.min.x)) *
                           4;
      const auto begin = rgba_.begin() + static_cast<ptrdiff_t>(first);
      rgba.insert(rgba.end(), begin, begin + ptrdiff_t{4} * rect.width());
    }
    messages.push_back(tev_update_image(name_, rect, rgba));
  }
  lock.unlock();
  const bool all_sent =
      std::all_of(messages.begin(), messages.end(), [this](const auto& message) { return connection_.send(message); });
  lock.lock();
  sending_ = false;
  lost_ = !all_sent;
}

} // namespace kindling::app
