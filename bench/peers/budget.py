"""Counts of samples that fit into a time, beside a filter; used inside of other renderers."""
# SPDX-License-Identifier: Apache-2.0
PROBE_SAMPLES = 8  # beyond the first one, for the time of one


def measure(render, clock):
    """Seconds of `render(samples, denoised)` that do not depend on samples, of each sample, and of the filter. `clock`: 0 the
    clock's, 1 those of all threads, of the pair that `render` returns."""
    one, several = render(1, False)[clock], render(1 + PROBE_SAMPLES, False)[clock]
    sample_s = max(several - one, 1e-6) / PROBE_SAMPLES
    return one - sample_s, sample_s, max(render(1, True)[clock] - one, 0.0)


def samples_within(budget_s, sample_s, filter_s):
    """At least one."""
    return max(1, int((budget_s - filter_s) / sample_s))
