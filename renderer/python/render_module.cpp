// The extension module kindling._render: renders glTF files to NumPy arrays.
//
// kindling/render.py gives its results names and documentation.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/base/phase_name.h"
#include "renderer/facade/renderer.h"

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <chrono>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <utility>
#include <vector>

namespace {

namespace nb = nanobind;
using namespace kindling;

[[noreturn]] void raise(const Error& error) {
  switch (error.kind) {
  case ErrorKind::input_output: PyErr_SetString(PyExc_OSError, error.message.c_str()); throw nb::python_error();
  case ErrorKind::render_failed: PyErr_SetString(PyExc_RuntimeError, error.message.c_str()); throw nb::python_error();
  default: throw nb::value_error(error.message.c_str());
  }
}

// Runs a render on a thread of its own, while the calling thread looks after signals and calls
// Python: progress(phase, fraction, samples per pixel) may return False to end it.
class Watched {
 public:
  Watched(nb::object progress, nb::object warn) : progress_(std::move(progress)), warn_(std::move(warn)) {}

  // Returns what work(options) does. Rethrows an exception of the calls, and KeyboardInterrupt,
  // after the work has ended.
  template <class Work>
  auto run(int threads, const Work& work) {
    RunOptions options;
    options.threads = threads;
    options.cancel = &cancel_;
    options.on_progress = [this](const ProgressSnapshot& snapshot) {
      const std::lock_guard lock(mutex_);
      snapshot_ = snapshot;
    };
    options.on_warning = [this](std::string_view message) {
      const std::lock_guard lock(mutex_);
      warnings_.emplace_back(message);
    };
    std::optional<decltype(work(options))> result;
    bool ended = false;
    std::thread worker([&] {
      auto found = work(options);
      const std::lock_guard lock(mutex_);
      result.emplace(std::move(found));
      ended = true;
      woken_.notify_one();
    });
    bool last = false;
    while (!last) {
      {
        const nb::gil_scoped_release release;
        std::unique_lock lock(mutex_);
        last = woken_.wait_for(lock, std::chrono::milliseconds(50), [&] { return ended; });
      }
      try {
        call();
      } catch (...) {
        if (!failure_) failure_ = std::current_exception();
        cancel_.cancel_now();
      }
    }
    {
      const nb::gil_scoped_release release;
      worker.join();
    }
    if (failure_) std::rethrow_exception(failure_);
    return std::move(*result);
  }

 private:
  void call() {
    std::optional<ProgressSnapshot> snapshot;
    std::vector<std::string> warnings;
    {
      const std::lock_guard lock(mutex_);
      snapshot = std::exchange(snapshot_, std::nullopt);
      warnings.swap(warnings_);
    }
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    if (failure_) return;
    for (const std::string& message : warnings) warn_(message);
    if (!snapshot || progress_.is_none()) return;
    const double fraction = snapshot->total > 0.0 ? snapshot->done / snapshot->total : 0.0;
    const nb::object answer = progress_(phase_name(snapshot->phase), fraction, snapshot->samples_per_pixel);
    if (answer.is(nb::handle(Py_False))) cancel_.cancel_now();
  }

  nb::object progress_, warn_;
  CancelToken cancel_;
  std::exception_ptr failure_;
  std::mutex mutex_;
  std::condition_variable woken_;
  std::optional<ProgressSnapshot> snapshot_; // guarded by mutex_, as are the next ones
  std::vector<std::string> warnings_;
};

Aov aov_of(const std::string& name) {
  const std::optional<Aov> aov = aov_from_name(name);
  if (aov) return *aov;
  std::string names;
  for (const AovInfo& info : kAovs) names += (names.empty() ? "" : ", ") + std::string(info.name);
  throw nb::value_error(("aovs: unknown layer '" + name + "'; use " + names).c_str());
}

// Returns rows of floats as a NumPy array of shape (height, width) or (height, width, channels).
nb::ndarray<nb::numpy, float> to_array(std::vector<float> values, const PixelRect& crop, int channels) {
  auto owned = std::make_unique<std::vector<float>>(std::move(values));
  float* data = owned->data();
  const nb::capsule owner(owned.release(),
                          [](void* memory) noexcept { delete static_cast<std::vector<float>*>(memory); });
  const auto height = static_cast<size_t>(crop.height()), width = static_cast<size_t>(crop.width());
  if (channels == 1) return nb::ndarray<nb::numpy, float>(data, {height, width}, owner);
  return nb::ndarray<nb::numpy, float>(data, {height, width, static_cast<size_t>(channels)}, owner);
}

nb::ndarray<nb::numpy, float> layer(const RenderedImage& image, const std::string& name) {
  const Aov aov = aov_of(name);
  return to_array(image.film.resolve(aov), image.film.crop(), aov_info(aov).channels);
}

void save(const RenderedImage& image, const std::string& file) {
  std::optional<Result<void>> written;
  {
    const nb::gil_scoped_release release;
    written = image.write(file);
  }
  if (!*written) raise(written->error());
}

using Triple = std::tuple<float, float, float>;

V3f vector_of(const Triple& triple) { return {std::get<0>(triple), std::get<1>(triple), std::get<2>(triple)}; }

std::unique_ptr<Renderer> load(const std::string& file, const std::string& env, const std::optional<Triple>& env_color,
                               const std::string& scene, const std::string& variant, const std::string& accelerator,
                               int threads, nb::object progress, nb::object warn) {
  WorldSettings settings;
  settings.env_file = env;
  if (env_color) settings.env_color = vector_of(*env_color);
  settings.scene_name = scene;
  settings.variant_name = variant;
  const std::optional<accel::Kind> kind = accel::kind_from_name(accelerator);
  if (!kind) throw nb::value_error(("accelerator: '" + accelerator + "', expected 'kdtree' or 'embree'").c_str());
  settings.accelerator = *kind;
  Watched watched(std::move(progress), std::move(warn));
  Result<Renderer> renderer =
      watched.run(threads, [&](const RunOptions& run) { return Renderer::load(file, settings, run); });
  if (!renderer) raise(renderer.error());
  return std::make_unique<Renderer>(std::move(renderer).value());
}

struct Options {
  std::optional<std::tuple<int, int>> size;
  std::optional<uint32_t> spp;
  uint32_t seed = 0;
  std::string camera;
  std::optional<Triple> orbit;
  Triple target{0.0f, 0.0f, 0.0f};
  std::optional<double> yfov_deg, time_s, time_limit_s;
  int max_bounces = 8;
  bool transparent_background = false;
  std::vector<std::string> aovs;
};

std::unique_ptr<RenderedImage> render_with(Renderer& renderer, const Options& options, int threads, nb::object progress,
                                           nb::object warn) {
  ImageSettings settings;
  if (options.size) settings.size_px = V2i(std::get<0>(*options.size), std::get<1>(*options.size));
  settings.spp = options.spp;
  settings.seed = options.seed;
  settings.camera = options.camera;
  if (options.orbit) settings.orbit = vector_of(*options.orbit);
  settings.target = vector_of(options.target);
  settings.yfov_deg = options.yfov_deg;
  settings.time_s = options.time_s;
  settings.time_limit_s = options.time_limit_s;
  settings.integrator.max_bounces = options.max_bounces;
  settings.integrator.transparent_background = options.transparent_background;
  for (const std::string& name : options.aovs) settings.aovs.insert(aov_of(name));
  Watched watched(std::move(progress), std::move(warn));
  Result<RenderedImage> image =
      watched.run(threads, [&](const RunOptions& run) { return renderer.render(settings, run); });
  if (!image) raise(image.error());
  return std::make_unique<RenderedImage>(std::move(image).value());
}

} // namespace

NB_MODULE(_render, module) {
  module.doc() = "Kindling's renderer; use kindling.render.";
  nb::class_<Options>(module, "Options")
      .def(nb::init<>())
      .def_rw("size", &Options::size, nb::arg().none())
      .def_rw("spp", &Options::spp, nb::arg().none())
      .def_rw("seed", &Options::seed)
      .def_rw("camera", &Options::camera)
      .def_rw("orbit", &Options::orbit, nb::arg().none())
      .def_rw("target", &Options::target)
      .def_rw("yfov_deg", &Options::yfov_deg, nb::arg().none())
      .def_rw("time_s", &Options::time_s, nb::arg().none())
      .def_rw("time_limit_s", &Options::time_limit_s, nb::arg().none())
      .def_rw("max_bounces", &Options::max_bounces)
      .def_rw("transparent_background", &Options::transparent_background)
      .def_rw("aovs", &Options::aovs);
  nb::class_<RenderedImage>(module, "RenderedImage")
      .def("layer", &layer)
      .def("save", &save)
      .def_ro("interrupted", &RenderedImage::interrupted);
  nb::class_<Renderer>(module, "Renderer")
      .def_static("load", &load, nb::arg("file"), nb::arg("env"), nb::arg("env_color").none(), nb::arg("scene"),
                  nb::arg("variant"), nb::arg("accelerator"), nb::arg("threads"), nb::arg("progress").none(),
                  nb::arg("warn"))
      .def("render", &render_with, nb::arg("options"), nb::arg("threads"), nb::arg("progress").none(), nb::arg("warn"))
      .def("cameras", &Renderer::cameras);
}
