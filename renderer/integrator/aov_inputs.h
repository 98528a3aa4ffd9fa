// Inputs of integrators for some AOVs alone.
// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kindling {

struct FrameMotion;
struct SurfaceNames;
class ShadowCatchers;

// Each may be null if its AOVs are not wanted. All but the names must outlive the integrator.
struct AovInputs {
  const SurfaceNames* names = nullptr;      // for mattes; read in the constructor alone
  const FrameMotion* motion = nullptr;      // for AovSet::needs_motion(); null: vectors of 0
  const ShadowCatchers* catchers = nullptr; // for Aov::shadow_catcher; null: nothing is caught
};

} // namespace kindling
