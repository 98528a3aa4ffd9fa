// A viewer without its window: a loop draws the film while a thread renders and events arrive.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/renderer.h"

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <mutex>
#include <string>
#include <thread>

namespace {

using namespace kindling;

void require(bool true_one, const std::string& what) {
  if (true_one) return;
  std::printf("failed: %s\n", what.c_str());
  std::exit(1);
}

// The texture that a window would show: the newest film, tone-mapped.
class Canvas {
 public:
  void draw(const Film& film) {
    std::vector<uint8_t> pixels = display_rgba8(film, view_);
    const std::lock_guard lock(mutex_);
    pixels_ = std::move(pixels);
    ++version_;
  }
  [[nodiscard]] size_t version() const {
    const std::lock_guard lock(mutex_);
    return version_;
  }
  [[nodiscard]] std::vector<uint8_t> pixels() const {
    const std::lock_guard lock(mutex_);
    return pixels_;
  }

 private:
  DisplayTransform view_ = DisplayTransform::create({}).value();
  mutable std::mutex mutex_;
  std::vector<uint8_t> pixels_;
  size_t version_ = 0;
};

// One render on a thread of its own, which the window's loop watches and may end.
class BackgroundRender {
 public:
  BackgroundRender(Renderer& renderer, ImageSettings settings, Canvas& canvas, CheckpointOptions checkpoint = {})
      : thread_([this, &renderer, settings = std::move(settings), &canvas, checkpoint = std::move(checkpoint)] {
          result_.emplace(renderer.render(settings, {.checkpoint = checkpoint,
                                                     .cancel = &cancel_,
                                                     .on_progress =
                                                         [this](const ProgressSnapshot& snapshot) {
                                                           if (snapshot.phase == Phase::build) built_ = true;
                                                         },
                                                     .on_pass = [&canvas](const Film& film) { canvas.draw(film); }}));
        }) {}
  void cancel() { cancel_.cancel_now(); }
  [[nodiscard]] bool built() const { return built_; }
  Result<RenderedImage> finish() {
    thread_.join();
    return std::move(*result_);
  }

 private:
  CancelToken cancel_;
  std::atomic<bool> built_{false};
  std::optional<Result<RenderedImage>> result_;
  std::thread thread_;
};

void wait_for_frame(const Canvas& canvas, size_t version) {
  while (canvas.version() <= version) std::this_thread::sleep_for(std::chrono::milliseconds(2));
}

} // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  Result<Renderer> loaded = Renderer::load(argv[1]);
  require(loaded.ok(), loaded.ok() ? "" : loaded.error().message);
  Renderer& renderer = loaded.value();
  Canvas canvas;
  ImageSettings settings;
  settings.size_px = V2i(48, 32);
  settings.spp = 1U << 20; // as long as the user looks

  // The first view refines until the user turns the camera.
  {
    BackgroundRender render(renderer, settings, canvas);
    wait_for_frame(canvas, 1);
    render.cancel();
    const Result<RenderedImage> image = render.finish();
    require(image.ok() && image.value().interrupted, "the first view is interrupted");
    require(render.built(), "the first view builds the world");
    settings.own_camera = image.value().camera;
  }

  // Three events turn it; none rebuilds the world.
  for (int event = 0; event < 3; ++event) {
    settings.own_camera->camera_to_world.rotate(V3f(0.0f, 0.05f, 0.0f));
    const std::vector<uint8_t> before = canvas.pixels();
    const size_t version = canvas.version();
    BackgroundRender render(renderer, settings, canvas);
    wait_for_frame(canvas, version);
    render.cancel();
    require(render.finish().ok(), "a turned view renders");
    require(!render.built(), "a turned view does not rebuild the world");
    require(canvas.pixels() != before, "a turned view shows another image");
  }

  // The final image is saved while it renders; the user closes the window, and a later session
  // resumes it.
  settings.spp = 64;
  const CheckpointOptions checkpoint{.file = argv[2]};
  {
    const size_t version = canvas.version();
    BackgroundRender render(renderer, settings, canvas, checkpoint);
    wait_for_frame(canvas, version);
    render.cancel();
    require(render.finish().ok(), "the final image begins");
  }
  const Result<RenderedImage> resumed = renderer.render(settings, {.checkpoint = checkpoint});
  require(resumed.ok() && !resumed.value().interrupted,
          resumed.ok() ? "the image is complete" : resumed.error().message);
  const Result<RenderedImage> whole = renderer.render(settings);
  require(whole.ok() && whole.value().linear_rgb() == resumed.value().linear_rgb(), "resuming gives the same pixels");

  // A checkpoint of another view is refused with the differing setting.
  settings.seed = 1;
  const Result<RenderedImage> refused = renderer.render(settings, {.checkpoint = checkpoint});
  require(!refused.ok() && refused.error().message.find("--seed: 0 in the file, 1 here") != std::string::npos,
          "another seed is refused");
  std::printf("%s\n", refused.error().message.c_str());
}
