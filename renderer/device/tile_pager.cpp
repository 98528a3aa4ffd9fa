// Requests, eviction and repeated launches of a pool of texture tiles.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/tile_pager.h"

#include "renderer/device/copy_texels.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <functional>
#include <string>
#include <utility>

namespace kindling {
namespace {

uint64_t request_words(const TilePlan& plan) { return (plan.tile_count() + 31U) / 32U; }

constexpr uint64_t kBytesOfSlot = kTileBytes + sizeof(uint32_t);           // texels, and the last use
constexpr uint64_t kBytesOfPath = sizeof(uint32_t) + 2 * sizeof(uint64_t); // what it missed; two queues
constexpr uint64_t kBytesOfPool = sizeof(TilePool) + sizeof(uint32_t);     // and the count of a queue

uint64_t bytes_without_slots(const TilePlan& plan, uint32_t paths) {
  return plan.textures.size() * sizeof(TextureTiles) + kBytesOfPool +
         sizeof(uint32_t) * (plan.tile_count() + request_words(plan)) + kBytesOfPath * paths;
}

} // namespace

uint64_t TilePager::bytes(const TilePlan& plan, uint32_t slots, uint32_t paths) {
  return bytes_without_slots(plan, paths) + slots * kBytesOfSlot;
}

uint32_t TilePager::slots_within(uint64_t bytes, const TilePlan& plan, uint32_t paths) {
  const uint64_t fixed = bytes_without_slots(plan, paths);
  return bytes <= fixed ? 0
                        : static_cast<uint32_t>(std::min<uint64_t>((bytes - fixed) / kBytesOfSlot, plan.tile_count()));
}

TilePager::TilePager(Device& device, std::span<const TextureView> textures, TilePlan plan, uint32_t slots,
                     uint32_t paths)
    : device_(device), textures_(textures), plan_(std::move(plan)), slot_count_(slots),
      slots_(plan_.tile_count(), TilePool::kNone), tiles_(slots, TilePool::kNone),
      device_textures_(device, plan_.textures.size()), device_pool_(device, 1), device_slots_(device, slots_.size()),
      texels_(device, size_t{slots} * kTileBytes), last_use_(device, slots), requests_(device, request_words(plan_)),
      missed_(device, paths), again_(device, paths), waiting_(device, paths), waiting_count_(device, 1) {
  assert(slots >= std::min(plan_.tiles_of_surface, plan_.tile_count()) && plan_.tile_count() > 0);
  for (TextureTiles& texture : plan_.textures) texture.pool = device_pool_.data();
  device_textures_.upload(plan_.textures);
  device_slots_.upload(slots_);
  last_use_.clear(slots);
  statistics_.tiles = plan_.tile_count();
  statistics_.slots = slots;
  statistics_.min_slots = std::min(plan_.tiles_of_surface, plan_.tile_count());
}

void TilePager::begin_launch() {
  device_pool_.upload(std::array{TilePool{.slots = device_slots_.data(),
                                          .texels = texels_.data(),
                                          .last_use = last_use_.data(),
                                          .requests = requests_.data(),
                                          .missed = missed_.data(),
                                          .launch = ++launch_}});
  requests_.clear(requests_.size());
  waiting_count_.clear(1);
}

std::vector<uint64_t> TilePager::waiting() {
  std::array<uint32_t, 1> count;
  waiting_count_.download(count);
  std::vector<uint64_t> paths(count[0]);
  waiting_.download(paths);
  return paths;
}

std::vector<uint32_t> TilePager::requests() {
  std::vector<uint32_t> words(requests_.size()), tiles;
  requests_.download(words);
  for (uint32_t i = 0; i < words.size(); ++i)
    for (uint32_t word = words[i]; word != 0; word &= word - 1)
      tiles.push_back(32 * i + static_cast<uint32_t>(std::countr_zero(word)));
  return tiles;
}

bool TilePager::load(std::span<const uint32_t> tiles, size_t& room) {
  std::vector<uint32_t> uses(slot_count_);
  last_use_.download(uses);
  std::vector<uint32_t> victims;
  for (uint32_t slot = 0; slot < slot_count_; ++slot)
    if (uses[slot] < launch_) victims.push_back(slot);
  room = victims.size();
  if (tiles.size() > room) return false;
  // Those that were never used are the first.
  const auto is_older = [&](uint32_t a, uint32_t b) { return std::pair(uses[a], a) < std::pair(uses[b], b); };
  std::ranges::nth_element(victims, victims.begin() + static_cast<ptrdiff_t>(tiles.size()), is_older);
  std::vector<std::byte> texels(kTileBytes);
  for (size_t i = 0; i < tiles.size(); ++i) {
    const uint32_t tile = tiles[i], slot = victims[i];
    if (tiles_[slot] != TilePool::kNone) {
      slots_[tiles_[slot]] = TilePool::kNone;
      ++statistics_.evicted;
    }
    tiles_[slot] = tile;
    slots_[tile] = slot;
    copy_tile(tile, texels.data());
    device_.upload(texels, texels_.data() + size_t{slot} * kTileBytes);
  }
  statistics_.loaded += tiles.size();
  device_slots_.upload(slots_);
  return true;
}

void TilePager::copy_tile(uint32_t tile, std::byte* to) const {
  const TilePlan::Source& source = plan_.sources[tile];
  const TextureView& texture = textures_[source.texture];
  const size_t texel_bytes = texture.pixel_bytes;
  const auto size_of = [&](int level) { return texture.levels[static_cast<size_t>(level)]; };
  if (source.several_levels) {
    for (int level = source.level; level < texture.level_count; ++level) {
      const auto [pixels, width, height] = size_of(level);
      const size_t row_bytes = static_cast<size_t>(width) * texel_bytes;
      copy_texels(texture, {level, 0, 0, width, height}, to, row_bytes);
      to += row_bytes * static_cast<size_t>(height);
    }
    return;
  }
  const auto [pixels, width, height] = size_of(source.level);
  const auto rows = static_cast<int>(plan_.textures[source.texture].rows);
  copy_texels(texture,
              {source.level, source.x, source.y, std::min(static_cast<int>(kTileWidth), width - source.x),
               std::min(rows, height - source.y)},
              to, kTileWidth * texel_bytes);
}

void TilePager::run(WaveTiles& wave, uint32_t count, const std::function<void(uint32_t)>& launch,
                    const std::function<bool()>& abandoned) {
  if (count == 0) return;
  wave = {device_pool_.data(), nullptr, waiting_.data(), waiting_count_.data()};
  begin_launch();
  launch(count);
  std::vector<uint64_t> current = waiting(); // that have run in the last launch
  std::vector<uint64_t> rest;                // the next ones at the end
  size_t together = count, ran = count;
  while (!abandoned()) {
    if (current.empty()) {
      if (rest.empty()) return;
      const size_t taken = std::min(together, rest.size());
      current.assign(rest.end() - static_cast<ptrdiff_t>(taken), rest.end());
      rest.resize(rest.size() - taken);
    } else {
      const std::vector<uint32_t> wanted = requests();
      size_t room = 0;
      if (!load(wanted, room)) {
        if (ran == 1) // its tiles have been promised room
          throw DeviceError(device_.name() + ": a path needs more texture tiles than the " +
                            std::to_string(slot_count_) + " that have room; use --device cpu");
        std::ranges::sort(current, std::greater());
        together = std::max<size_t>(std::min(current.size() * room / wanted.size(), current.size() / 2), 1);
        rest.insert(rest.end(), current.begin(), current.end() - static_cast<ptrdiff_t>(together));
        current.erase(current.begin(), current.end() - static_cast<ptrdiff_t>(together));
      }
    }
    again_.upload(current);
    wave.again = again_.data();
    begin_launch();
    ran = current.size();
    launch(static_cast<uint32_t>(ran));
    statistics_.stages_again += ran;
    current = waiting();
    if (current.empty() && together <= count / 2) together *= 2;
  }
}

} // namespace kindling
