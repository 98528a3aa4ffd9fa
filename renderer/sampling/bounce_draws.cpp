// Random numbers of many path vertices.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/bounce_draws.h"

#include "renderer/base/lanes.h"

#include <algorithm>
#include <array>
#include <cassert>

namespace kindling {
namespace {

// The addresses of eight vertices.
struct AddressLanes {
  Words8 key, index, dimension;
};

// Those of `addresses`, which are at most eight; the last one is repeated.
AddressLanes gather(std::span<const BounceAddress> addresses) {
  AddressLanes lanes;
  for (size_t lane = 0; lane < Lanes::kCount; ++lane) {
    const BounceAddress& at = addresses[std::min(lane, addresses.size() - 1)];
    lanes.key[lane] = at.address.key, lanes.index[lane] = at.address.index, lanes.dimension[lane] = at.dimension;
  }
  return lanes;
}

// A set of four dimensions for eight vertices.
class SetLanes {
 public:
  SetLanes(const AddressLanes& at, uint32_t set) {
    const Words8 mixed_key = 0x9e3779b9U + (at.key << 6) + (at.key >> 2); // of hash_combine()
    seed_ = owen_sobol::hash_words(at.key ^ (at.dimension + set + mixed_key));
    index_ = reverse(owen_sobol::scramble_reversed(reverse(at.index), seed_));
  }

  // Returns the two numbers of the first or of the second pair.
  void draw_pair(size_t pair, Lanes& first, Lanes& second) const {
    const Words8 index = pair == 0 ? index_ : owen_sobol::second_pair_index(index_);
    first = draw(index, 2 * pair);
    second = draw(owen_sobol::second_reversed(index), 2 * pair + 1);
  }
  [[nodiscard]] Lanes draw_last() const {
    return draw(owen_sobol::second_reversed(owen_sobol::second_pair_index(index_)), 3);
  }

 private:
  static Words8 reverse(const Words8& x) { return owen_sobol::reverse_bits(x); }
  [[nodiscard]] Lanes draw(const Words8& reversed, size_t coordinate) const {
    const Words8 seed = owen_sobol::hash_words(seed_ ^ Sampler::kCoordinateSeeds[coordinate]);
    return to_unit_float(reverse(owen_sobol::scramble_reversed(reversed, seed)));
  }

  Words8 seed_, index_;
};

// Eight vertices at a time by lanes(addresses, draws), except where one by one is faster or samples
// have strata.
template <typename Draws, typename OneByOne, typename InLanes>
void draw_all(std::span<const BounceAddress> addresses, std::span<Draws> draws, const OneByOne& one,
              const InLanes& lanes) {
  assert(addresses.size() == draws.size());
  const bool stratified = !addresses.empty() && addresses[0].address.strata != 0;
  for (size_t first = 0; first < addresses.size(); first += Lanes::kCount) {
    const size_t count = std::min(Lanes::kCount, addresses.size() - first);
    if (stratified || count < 3) {
      for (size_t i = first; i < first + count; ++i)
        draws[i] = one(draw_bounce(addresses[i].address, addresses[i].dimension));
      continue;
    }
    lanes(gather(addresses.subspan(first, count)), draws.subspan(first, count));
  }
}

} // namespace

void draw_bounces(std::span<const BounceAddress> addresses, std::span<BounceDraws> draws) {
  draw_all(
      addresses, draws, [](const BounceDraws& drawn) { return drawn; },
      [](const AddressLanes& at, std::span<BounceDraws> of_lanes) {
        Lanes columns[Lanes::kCount];
        for (uint32_t set = 0; set < 2; ++set) {
          const SetLanes numbers(at, set);
          for (size_t pair = 0; pair < 2; ++pair)
            numbers.draw_pair(pair, columns[set * 4 + pair * 2], columns[set * 4 + pair * 2 + 1]);
        }
        LaneRows rows;
        rows.store_columns(columns);
        for (size_t lane = 0; lane < of_lanes.size(); ++lane) {
          const float* const u = rows[lane];
          of_lanes[lane] = {{u[0], u[1]}, {u[2], u[3]}, {u[4], u[5]}, u[6], u[7]};
        }
      });
}

void draw_lights(std::span<const BounceAddress> addresses, std::span<LightDraws> draws) {
  draw_all(
      addresses, draws,
      [](const BounceDraws& drawn) {
        return LightDraws{drawn.light, drawn.spare};
      },
      [](const AddressLanes& at, std::span<LightDraws> of_lanes) {
        const SetLanes numbers(at, 1);
        Lanes x, y;
        numbers.draw_pair(0, x, y);
        const Lanes spare = numbers.draw_last();
        for (size_t lane = 0; lane < of_lanes.size(); ++lane) of_lanes[lane] = {{x[lane], y[lane]}, spare[lane]};
      });
}

} // namespace kindling
