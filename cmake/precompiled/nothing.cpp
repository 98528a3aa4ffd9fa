// A target of precompiled headers needs a source.
// SPDX-License-Identifier: Apache-2.0
