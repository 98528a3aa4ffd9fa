// Sorts photons of a device, and brings trees of them there.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/device/photon_maps_on_device.h"

#include "renderer/integrator/photons/photon_map.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <utility>

namespace kindling {

PhotonMapsOnDevice::PhotonMapsOnDevice(Device& device, const PhotonMapSizes& sizes, uint32_t stored)
    : device_(device), sizes_(sizes), stored_(sizes.empty() ? 0 : stored), views_(device, stored_.size()),
      left_(stored_.size()) {
  for (Stored& map : stored_) {
    map.nodes.grow(device, sizes.max_photons());
    map.photons.grow(device, sizes.max_photons());
  }
}

uint32_t PhotonMapsOnDevice::filling(uint32_t wave_size, const PhotonMapSizes& sizes, uint64_t pixels) {
  const uint64_t samples_of_map = std::max<uint64_t>(pixels * sizes.samples, 1);
  return static_cast<uint32_t>(std::clamp<uint64_t>(wave_size / samples_of_map, 1, kMaxStored));
}

PhotonMapsOnDevice::Maps PhotonMapsOnDevice::of(const SampleRange& samples) const {
  return {samples.first / sizes_.samples, (samples.end - 1) / sizes_.samples + 1};
}

PhotonMapsOnDevice::Maps PhotonMapsOnDevice::absent(const SampleRange& samples) const {
  Maps maps = of(samples);
  assert(maps.count() <= stored_.size());
  const auto is_stored = [&](uint32_t map) { return stored_[map % stored_.size()].number == map; };
  while (!maps.empty() && is_stored(maps.first)) ++maps.first;
  while (!maps.empty() && is_stored(maps.end - 1)) --maps.end;
  return maps;
}

void PhotonMapsOnDevice::begin(const Maps& maps) {
  building_ = maps;
  for (std::vector<Left>& left : left_) left.clear();
  for (uint32_t map = maps.first; map < maps.end; ++map) stored_[map % stored_.size()].number.reset();
}

void PhotonMapsOnDevice::add(uint64_t first, uint32_t surfaces, std::span<const WavePhoton> photons) {
  for (const WavePhoton& found : photons) {
    const uint64_t path = first + found.slot;
    left_[path / sizes_.paths].push_back({PhotonMapSizes::order_of(path % sizes_.paths, surfaces), found.photon});
  }
}

void PhotonMapsOnDevice::build() {
  std::vector<std::optional<PhotonMap>> trees(building_.count());
  tbb::parallel_for(size_t{0}, trees.size(), [&](size_t i) {
    std::vector<std::pair<uint64_t, uint32_t>> order; // and the place among those that were left
    order.reserve(left_[i].size());
    for (const Left& left : left_[i]) order.emplace_back(left.order, static_cast<uint32_t>(order.size()));
    std::sort(order.begin(), order.end());
    std::vector<Photon> photons;
    photons.reserve(order.size());
    for (const auto& [number, place] : order) photons.push_back(left_[i][place].photon);
    trees[i].emplace(std::move(photons));
  });
  for (size_t i = 0; i < trees.size(); ++i) {
    const auto number = static_cast<uint32_t>(building_.first + i);
    Stored& map = stored_[number % stored_.size()];
    const PhotonMapView here = trees[i]->view();
    map.nodes.grow(device_, here.nodes.size());
    map.photons.grow(device_, here.photons.size());
    map.nodes.upload(here.nodes);
    map.photons.upload(here.photons);
    map.view = {map.nodes.span().first(here.nodes.size()), map.photons.span().first(here.photons.size())};
    map.number = number;
  }
}

WavePhotonMaps PhotonMapsOnDevice::of_samples(const SampleRange& samples) {
  const Maps maps = of(samples);
  std::array<PhotonMapView, kMaxStored> views;
  for (uint32_t map = maps.first; map < maps.end; ++map) views[map - maps.first] = stored_[map % stored_.size()].view;
  views_.upload(std::span(views).first(maps.count()));
  return {views_.data(), maps.first, sizes_.samples, samples.first};
}

} // namespace kindling
