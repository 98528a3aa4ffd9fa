// The library in a few calls: loads a glTF file, renders it with changing settings, writes images.
// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "renderer/base/progress.h"
#include "renderer/base/result.h"
#include "renderer/camera/place_camera.h"
#include "renderer/facade/path_ways.h"
#include "renderer/film/film.h"
#include "renderer/film/write_film.h"
#include "renderer/scene/scene.h"
#include "renderer/session/checkpoint.h"
#include "renderer/session/image_settings.h"
#include "renderer/session/render_session.h"
#include "renderer/world/surface_point.h"

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kindling {

// Threads, checkpoint, cancelling and callbacks of one call. Nothing here changes an image.
// Functions may be empty; they are called from any thread, but from one at a time, and must return
// quickly.
struct RunOptions {
  int threads = 0;                     // 0: all
  CheckpointOptions checkpoint;        // of render(): saves to this file, and resumes from it if it exists
  const CancelToken* cancel = nullptr; // ends render(); may be set from any thread and from the functions below
  std::function<void(const ProgressSnapshot&)> on_progress;
  std::function<void(std::string_view)> on_warning; // a sentence about something skipped or replaced
  // The film after each pass over the image, valid during the call; see
  // RenderContinuity::after_pass.
  std::function<void(const Film&)> on_pass;
  // Does not decide again on the studio and backs of faces, for a camera that moves: what the last
  // image decided holds. The image is that of the settings that Renderer::decided() returns.
  bool keep_decisions = false;
};

// An image of a film. All pixels are those of the crop window, rows from the top.
struct RenderedImage {
  Film film;
  RenderStatistics statistics;
  bool interrupted = false; // cancelled before all samples were taken
  PlacedCamera camera;      // in focus
  ImageMetadata metadata;
  std::vector<std::filesystem::path> inputs; // files of the scene and its environment, never overwritten by write()

  // Returns linear Rec. 709, premultiplied by alpha, 3 floats for each pixel.
  [[nodiscard]] std::vector<float> linear_rgb() const { return film.resolve(Aov::beauty); }
  // Writes a .png, through the view of `display`, or a .exr file. Fails (usage, input_output), also
  // for the name of an input.
  [[nodiscard]] Result<void> write(const std::filesystem::path& file, const WriteOptions& options = {},
                                   const DisplayOptions& display = {}) const;
};

// The decisions that `auto` stands for: with these settings in its place, any view of the scene
// gets the same World.
struct DecidedSettings {
  Backfaces backfaces = Backfaces::automatic; // automatic: nothing was to be decided
  Studio studio = Studio::automatic;          // likewise
};

// A surface that is visible in an image.
struct PickedSurface {
  std::string node;     // name of the node whose mesh it is; empty if it has none
  std::string material; // name of the material
  float depth_m = 0.0f; // along the camera's axis
  SurfacePoint surface;
};

// One sample of an image, rendered again.
struct ReplayedPath {
  V2i pixel{0, 0}, size_px{0, 0};
  uint32_t sample = 0;
  ReplayedSample replayed;
  std::vector<PathWay> ways; // by vertex of the trace
};

// A scene and its World. The World is built by the first render() and kept: a render that changes
// the camera, the size, the sampling or the integrator begins at once; one that changes the time of
// an animated scene rebuilds the moving geometry. One render() at a time.
//
// Images are those of `kindling render` with the same settings, to the bit; errors have the same
// messages.
class Renderer {
 public:
  // Loads a scene file, and the environment of the settings. Fails as load_scene() and
  // load_environment() do, and (usage) if the file lacks the scene or the variant of the settings.
  [[nodiscard]] static Result<Renderer> load(const std::filesystem::path& file, const WorldSettings& settings = {},
                                             const RunOptions& run = {});
  // Takes a scene from memory. Checkpoints need Scene::content_hash, a number that identifies its
  // contents.
  [[nodiscard]] static Result<Renderer> take(Scene scene, const WorldSettings& settings = {});

  // Renders one image. The camera is ImageSettings::own_camera or orbit, else a camera of the
  // scene, else one fitted to its bounds; a scene without lights gets the built-in environment.
  // CancelToken::cancel_now() ends the render within milliseconds, CancelToken::cancel() after the
  // current pass; the image then holds the samples so far. A build is not cancelled: the World is
  // kept for the next render. With a checkpoint, fails (usage) if the file belongs to another
  // render, with the differing settings, or is an input.
  [[nodiscard]] Result<RenderedImage> render(const ImageSettings& image, const RunOptions& run = {});

  // Returns the names of the cameras of the scene at rest, as ImageSettings::camera takes them.
  [[nodiscard]] std::vector<std::string> cameras() const;
  // Returns the bounds of the World of the last render; empty before the first.
  [[nodiscard]] Box3f bounds() const;
  // Returns the decisions for the last image.
  [[nodiscard]] DecidedSettings decided() const;
  // Returns the scene. It is posed for the last image, and its static meshes are consumed.
  [[nodiscard]] const Scene& scene() const;
  // Returns the files that the scene and its environment were read from.
  [[nodiscard]] std::vector<std::filesystem::path> inputs() const;

  // Returns the surface that the last image, or the one being rendered, shows at this position:
  // fractions of its width and height from the upper left corner. Nothing where none is visible,
  // and while a World is built. May be called from any thread at any time.
  [[nodiscard]] std::optional<PickedSurface> pick(const V2f& position) const;
  // Renders a sample of the pixel at this position again, of the last image or the one being
  // rendered; `sample` counts from 0 and wraps around. A guide that is not trained yet is trained
  // for this, which may take seconds, and the next render() waits for it. Fails (usage) before the
  // first image and while a World is built. May be called from any thread at any time.
  [[nodiscard]] Result<ReplayedPath> replay(const V2f& position, uint32_t sample) const;

  Renderer(Renderer&&) noexcept;
  Renderer& operator=(Renderer&&) noexcept;
  ~Renderer();

 private:
  struct Impl;
  explicit Renderer(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

} // namespace kindling
