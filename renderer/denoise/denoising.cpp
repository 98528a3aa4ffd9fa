// Names of the qualities of denoising.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/denoise/denoising.h"

namespace kindling {

std::string_view denoising_name(Denoising denoising) {
  switch (denoising) {
  case Denoising::off: return "off";
  case Denoising::fast: return "fast";
  case Denoising::best: return "best";
  }
  return "";
}

std::optional<Denoising> denoising_from_name(std::string_view name) {
  for (const Denoising denoising : {Denoising::off, Denoising::fast, Denoising::best})
    if (name == denoising_name(denoising)) return denoising;
  return std::nullopt;
}

} // namespace kindling
