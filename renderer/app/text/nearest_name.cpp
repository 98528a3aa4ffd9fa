// Suggestions for unknown flags: by edit distance, and by the names that other renderers use.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/text/parse_values.h"

#include <algorithm>

namespace kindling::app {

namespace {

struct Synonym {
  std::string_view word; // the name in another renderer or tool
  std::string_view name;
};
constexpr Synonym kSynonyms[] = {
    {"--adaptive-threshold", "--noise-threshold"},
    {"--aperture", "--f-stop"},
    {"--backend", "--accel"},
    {"--bg", "--background"},
    {"--bounces", "--max-bounces"},
    {"--camera-name", "--camera"},
    {"--cores", "--threads"},
    {"--cropwindow", "--crop"},
    {"--depth", "--max-bounces"},
    {"--device", "--accel"},
    {"--environment", "--env"},
    {"--environment-map", "--env"},
    {"--envmap", "--env"},
    {"--field-of-view", "--fov"},
    {"--fstop", "--f-stop"},
    {"--hdr", "--env"},
    {"--hdri", "--env"},
    {"--height", "--size"},
    {"--ibl", "--env"},
    {"--jobs", "--threads"},
    {"--max-depth", "--max-bounces"},
    {"--max-path-length", "--max-bounces"},
    {"--max-samples", "--spp"},
    {"--min-samples", "--min-spp"},
    {"--mode", "--integrator"},
    {"--nthreads", "--threads"},
    {"--num-samples", "--spp"},
    {"--out", "--output"},
    {"--outfile", "--output"},
    {"--output-file", "--output"},
    {"--passes", "--spp"},
    {"--pixel-filter", "--filter"},
    {"--pixelsamples", "--spp"},
    {"--render-output", "--output"},
    {"--renderer", "--integrator"},
    {"--res", "--size"},
    {"--resolution", "--size"},
    {"--samples", "--spp"},
    {"--samples-per-pixel", "--spp"},
    {"--skybox", "--env"},
    {"--sun-size", "--sun-angle"},
    {"--timeout", "--time-limit"},
    {"--tonemap", "--view"},
    {"--tonemapping", "--view"},
    {"--width", "--size"},
};

// Levenshtein's distance between two short words.
size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<size_t> row(b.size() + 1);
  for (size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (size_t i = 1; i <= a.size(); ++i) {
    size_t diagonal = row[0];
    row[0] = i;
    for (size_t j = 1; j <= b.size(); ++j) {
      const size_t substitution = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = row[j];
      row[j] = std::min({substitution, row[j] + 1, row[j - 1] + 1});
    }
  }
  return row[b.size()];
}

} // namespace

std::string nearest_name(std::string_view word, const std::vector<std::string>& candidates) {
  if (word.size() > 64) return {};
  std::string best;
  size_t best_distance = std::max<size_t>(1, word.size() / 3) + 1;
  const auto consider = [&](std::string_view name, std::string_view meant) {
    const size_t distance = edit_distance(word, name);
    if (distance >= best_distance) return;
    best = meant;
    best_distance = distance;
  };
  for (const std::string& candidate : candidates) consider(candidate, candidate);
  for (const Synonym& synonym : kSynonyms)
    if (std::find(candidates.begin(), candidates.end(), synonym.name) != candidates.end())
      consider(synonym.word, synonym.name);
  return best;
}

} // namespace kindling::app
