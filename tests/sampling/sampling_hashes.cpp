// Prints hashes of samplers and distributions, for compare_compilers.py.
//
// It includes the sources themselves, so that it needs no library but Imath's headers.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/sampling/alias_table.cpp"
#include "renderer/sampling/bounce_draws.h"
#include "renderer/sampling/distribution_1d.cpp"
#include "renderer/sampling/draw_eight.h"
#include "renderer/sampling/jittered.cpp"
#include "renderer/sampling/quantized_cdf.cpp"
#include "renderer/sampling/sampler.cpp"
#include "tests/base/result_hash.h"

#include <array>
#include <vector>

namespace {

using namespace kindling;
using test::Inputs;
using test::ResultHash;

void print_samplers(int count) {
  Inputs inputs{test::Random(1)};
  ResultHash hash;
  for (const SamplerKind kind :
       {SamplerKind::blue_noise, SamplerKind::sobol, SamplerKind::independent, SamplerKind::jittered})
    for (const uint32_t samples : {1U, 12U, 64U, 1000U}) {
      const Sampler sampler(static_cast<uint32_t>(inputs.random.next_u64()), kind, samples);
      std::array<SampleAddress, 8> eight;
      for (int i = 0; i < count / 16; ++i) {
        const uint64_t bits = inputs.random.next_u64();
        const V2i pixel(static_cast<int>(bits & 0xfff), static_cast<int>(bits >> 12 & 0xfff));
        const SampleAddress address = sampler.address(pixel, static_cast<uint32_t>(bits >> 32) % (2 * samples));
        const auto dimension = static_cast<uint32_t>(bits >> 24 & 0x3f);
        hash.add(Sampler::sample_1d(address, dimension));
        hash.add(Sampler::sample_2d(address, dimension));
        const BounceDraws draws = draw_bounce(address, dimension);
        for (const V2f& u : {draws.choice, draws.direction, draws.light}) hash.add(u);
        hash.add(V2f(draws.roulette, draws.spare));
        eight[static_cast<size_t>(i) % 8] = address;
        if (i % 8 != 7) continue;
        const Imath::Vec2<Lanes> draws_of_eight = draw_eight(eight, dimension);
        for (size_t lane = 0; lane < 8; ++lane) hash.add(V2f(draws_of_eight.x[lane], draws_of_eight.y[lane]));
      }
    }
  hash.print("samplers");
}

void print_distributions(const char* name, bool special, int count) {
  Inputs inputs{test::Random(2), special};
  ResultHash hash;
  for (size_t size = 1; size < 40; ++size) {
    std::vector<float> weights(size);
    for (float& w : weights) w = inputs.any(0.0f, 1.0f);
    const Distribution1D distribution(weights);
    const AliasTable table(weights);
    for (int i = 0; i < count / 40; ++i) {
      const auto sample = distribution.sample(inputs.number());
      hash.add(sample.x);
      hash.add(sample.pdf);
      hash.add(sample.index);
      hash.add(distribution.pdf(inputs.any(-0.1f, 1.1f)));
      const auto chosen = table.sample(inputs.random.next_2d());
      hash.add(chosen.index);
      hash.add(chosen.probability);
    }
  }
  hash.print(name);
}

} // namespace

int main(int argc, char** argv) {
  const int count = test::input_count(argc, argv, 80000);
  print_samplers(count);
  test::print_usual_and_special("distributions", count, print_distributions);
  return 0;
}
