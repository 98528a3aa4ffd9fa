// Runs the steps of a render for Renderer: pose, checkpoint, World, render loop, image.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/facade/renderer.h"

#include "renderer/facade/choose.h"
#include "renderer/facade/lens.h"
#include "renderer/facade/render_scene.h"
#include "renderer/facade/render_stage.h"
#include "renderer/image/input_files.h"
#include "renderer/integrator/find_focus.h"
#include "renderer/session/image_metadata.h"
#include "renderer/session/matte_metadata.h"
#include "renderer/session/render_identity.h"

#include <fmt/format.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <mutex>
#include <optional>
#include <shared_mutex>
#include <utility>

namespace kindling {

namespace {

// Hands progress and warnings to the functions of a RunOptions.
class RunListener final : public ProgressListener {
 public:
  explicit RunListener(const RunOptions& run) : run_(run) {}
  void on_progress(const ProgressSnapshot& snapshot) override {
    if (run_.on_progress) run_.on_progress(snapshot);
  }
  void on_warning(std::string_view message) override {
    if (run_.on_warning) run_.on_warning(message);
  }
  void on_info(std::string_view) override {}

 private:
  const RunOptions& run_;
};

std::optional<tbb::global_control> limit_threads(int threads) {
  std::optional<tbb::global_control> limit;
  if (threads > 0) limit.emplace(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
  return limit;
}

std::vector<std::filesystem::path> inputs_of(const RenderScene& scene) {
  std::vector<std::filesystem::path> inputs = scene.files;
  if (!scene.settings.env_file.empty()) inputs.push_back(scene.settings.env_file);
  return inputs;
}

} // namespace

struct Renderer::Impl {
  explicit Impl(std::unique_ptr<RenderScene> loaded) : scene(std::move(loaded)) {}

  std::unique_ptr<RenderScene> scene;
  std::vector<std::string> cameras;
  bool failed = false; // in a build, which consumed the scene
  // Held by render() while it changes the World and the stage, and by pick().
  mutable std::shared_mutex stage_mutex;
  std::optional<RenderStage> stage; // of the last image
  RenderSettings settings;          // likewise

  // What the last image has learned, for replays: unset until then.
  std::mutex learned_mutex;
  std::optional<LearnedPaths> learned;
  // Returns that; learns it if a replay comes first. Needs the stage.
  [[nodiscard]] Result<LearnedPaths> learned_by_image() {
    const std::lock_guard training(learned_mutex);
    if (!learned) {
      Result<LearnedPaths> again = train_again(*stage->world, *stage->camera, settings);
      if (!again.ok()) return again.error();
      learned = std::move(again).value();
    }
    return *learned;
  }
};

Renderer::Renderer(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {
  RenderScene& scene = *impl_->scene;
  scene.keep();
  if (const Result<PosedScene> posed = pose_scene(scene.scene, {.scene = scene.root}); posed.ok())
    impl_->cameras = camera_names(scene.scene, posed.value());
}
Renderer::Renderer(Renderer&&) noexcept = default;
Renderer& Renderer::operator=(Renderer&&) noexcept = default;
Renderer::~Renderer() = default;

Result<Renderer> Renderer::load(const std::filesystem::path& file, const WorldSettings& settings,
                                const RunOptions& run) {
  const auto limit = limit_threads(run.threads);
  RunListener listener(run);
  Result<std::unique_ptr<RenderScene>> scene = load_render_scene(file, settings, &listener);
  if (!scene.ok()) return scene.error();
  return Renderer(std::make_unique<Impl>(std::move(scene).value()));
}

Result<Renderer> Renderer::take(Scene scene, const WorldSettings& settings) {
  Result<std::unique_ptr<RenderScene>> taken = take_render_scene(std::move(scene), settings);
  if (!taken.ok()) return taken.error();
  return Renderer(std::make_unique<Impl>(std::move(taken).value()));
}

Result<RenderedImage> Renderer::render(const ImageSettings& image, const RunOptions& run) {
  RenderScene& scene = *impl_->scene;
  if (impl_->failed)
    return Error{ErrorKind::render_failed, "the scene was consumed by a build that failed; load it again"};
  const auto limit = limit_threads(run.threads);
  RunListener listener(run);

  // --- the checkpoint, locked before any work ----------------------------------------------------
  std::unique_ptr<Checkpoint> checkpoint;
  if (run.checkpoint.enabled()) {
    for (const std::filesystem::path& written : files_of_checkpoint(run.checkpoint.file))
      if (Result<void> free = check_not_among(written, inputs_of(scene)); !free.ok()) return free.error();
    if (scene.content_hash == 0)
      return usage_error("a scene without Scene::content_hash cannot have a checkpoint; set it to a number that "
                         "identifies the contents of the scene");
    const auto warn = [&listener](const std::string& message) { listener.on_warning(message); };
    Result<std::unique_ptr<Checkpoint>> opened = Checkpoint::open(run.checkpoint, {.warning = warn, .note = {}});
    if (!opened.ok()) return opened.error();
    checkpoint = std::move(opened).value();
  }

  // --- pose, identity, World ---------------------------------------------------------------------
  std::unique_lock changing(impl_->stage_mutex);
  impl_->stage.reset();
  impl_->learned.reset();
  scene.keeps_decisions = run.keep_decisions;
  Result<PosedImage> posed = pose_image(scene, image);
  if (!posed.ok()) return posed.error();
  RenderSettings settings = to_render_settings(image, posed.value().size_px);
  settings.threads = run.threads;
  AccumulationIdentity identity = make_identity(scene.settings, image, posed.value().resolved, scene.content_hash);
  if (checkpoint)
    if (Result<void> begun = checkpoint->begin(identity); !begun.ok()) return begun.error();
  Result<RenderStage> built = build_stage(scene, std::move(posed).value(), image, true, nullptr, listener);
  if (!built.ok()) {
    impl_->failed = built.error().kind == ErrorKind::render_failed;
    return built.error();
  }
  const RenderStage& stage = impl_->stage.emplace(std::move(built).value());
  settings.names = scene.names;
  settings.motion = stage.motion;
  settings.catchers = stage.catchers;
  impl_->settings = settings;
  changing.unlock();

  MetadataFacts facts;
  facts.scene_file = scene.source;
  facts.scene_hash = scene.content_hash;
  facts.integrator = integrator_name(image.integrator.kind);
  facts.accelerator = accel::kind_description(scene.settings.accelerator);
  facts.seed = image.seed;
  facts.load_s = scene.load_s;
  facts.build_s = stage.build_s;
  facts.spp_wanted = settings.wanted_samples().count();
  const auto metadata = [&] {
    ImageMetadata result = make_metadata(facts, *stage.camera);
    add_lens_metadata(stage.placed_camera.camera.lens, result);
    if (scene.names) add_matte_metadata(*scene.names, settings.aovs, result);
    return result;
  };

  // --- the render loop ---------------------------------------------------------------------------
  RenderContinuity continuity;
  if (checkpoint) {
    checkpoint->set_metadata(metadata_to_json(metadata()));
    continuity = checkpoint->continuity();
  }
  continuity.after_training = [&impl = *impl_](const LearnedPaths& learned) {
    const std::lock_guard setting(impl.learned_mutex);
    impl.learned = learned;
  };
  if (run.on_pass)
    continuity.after_pass = [&](const RenderState& state) {
      const PixelRect wanted = settings.wanted_pixels();
      if (state.film.crop() == wanted)
        run.on_pass(state.film);
      else
        run.on_pass(state.film.cut(wanted));
    };
  Result<RenderOutcome> rendered =
      kindling::render(*stage.world, *stage.camera, settings, run.cancel, &listener, std::move(continuity));
  if (!rendered.ok()) return rendered.error();
  if (const std::string failure = scene.texture_memory ? scene.texture_memory->failure() : ""; !failure.empty())
    return Error{ErrorKind::input_output, "--texture-memory: textures could not be read back: " + failure};
  if (checkpoint && !checkpoint->last_save().ok()) return checkpoint->last_save().error();

  RenderOutcome& outcome = rendered.value();
  const RayCounters& rays = outcome.statistics.rays;
  if (rays.first_non_finite) {
    const auto& [pixel, sample] = *rays.first_non_finite;
    listener.on_warning(fmt::format("non-finite radiance at pixel ({}, {}), sample {} ({} samples dropped in all)",
                                    pixel.x, pixel.y, sample, rays.non_finite));
  }
  facts.interrupted = outcome.interrupted;
  facts.spp = outcome.statistics.samples_per_pixel;
  facts.threads = outcome.statistics.threads;
  facts.render_s = outcome.statistics.render_s;
  return RenderedImage{
      std::move(outcome.film), std::move(outcome.statistics), outcome.interrupted, stage.placed_camera, metadata(),
      inputs_of(scene)};
}

DecidedSettings Renderer::decided() const {
  DecidedSettings decided;
  if (const std::optional<ViewDecisions>& decisions = impl_->scene->decisions) {
    if (decisions->backs) decided.backfaces = decisions->backs->in_the_way() ? Backfaces::cull : Backfaces::show;
    if (decisions->light) decided.studio = decisions->light->studio ? Studio::on : Studio::off;
  }
  return decided;
}

const Scene& Renderer::scene() const { return impl_->scene->scene; }

std::vector<std::filesystem::path> Renderer::inputs() const { return inputs_of(*impl_->scene); }

std::optional<PickedSurface> Renderer::pick(const V2f& position) const {
  const std::shared_lock using_stage(impl_->stage_mutex, std::try_to_lock);
  if (!using_stage.owns_lock() || !impl_->stage) return std::nullopt;
  const RenderStage& stage = *impl_->stage;
  const std::optional<FoundSurface> found = find_surface(*stage.world, *stage.camera, position * V2f(stage.size_px));
  if (!found) return std::nullopt;
  PickedSurface picked{{}, stage.world->material_name(found->surface.material), found->depth_m, found->surface};
  const std::vector<Node>& nodes = impl_->scene->scene.nodes;
  if (const int node = stage.world->node_of(found->hit); node >= 0 && static_cast<size_t>(node) < nodes.size())
    picked.node = nodes[static_cast<size_t>(node)].name;
  return picked;
}

Result<ReplayedPath> Renderer::replay(const V2f& position, uint32_t sample) const {
  const std::shared_lock using_stage(impl_->stage_mutex, std::try_to_lock);
  if (!using_stage.owns_lock() || !impl_->stage) return usage_error("there is no image whose samples could be traced");
  const RenderStage& stage = *impl_->stage;
  ReplayedPath path{.size_px = stage.size_px, .sample = sample % impl_->settings.samples_per_pixel};
  for (int axis = 0; axis < 2; ++axis)
    path.pixel[axis] = std::clamp(static_cast<int>(position[axis] * static_cast<float>(stage.size_px[axis])), 0,
                                  stage.size_px[axis] - 1);
  const Result<LearnedPaths> learned = impl_->learned_by_image();
  if (!learned.ok()) return learned.error();
  Result<ReplayedSample> replayed =
      replay_sample(*stage.world, *stage.camera, impl_->settings, learned.value(), path.pixel, path.sample);
  if (!replayed.ok()) return replayed.error();
  path.replayed = std::move(replayed).value();
  path.ways = find_path_ways(*stage.camera, path.replayed.trace, stage.world->bounds);
  return path;
}

std::vector<std::string> Renderer::cameras() const { return impl_->cameras; }

Box3f Renderer::bounds() const { return impl_->scene->world ? impl_->scene->world->bounds : Box3f(); }

Result<void> RenderedImage::write(const std::filesystem::path& file, const WriteOptions& options,
                                  const DisplayOptions& display) const {
  const Result<DisplayTransform> view = DisplayTransform::create(display);
  if (!view.ok()) return view.error();
  for (const std::vector<std::filesystem::path>& read : {inputs, view.value().files()})
    if (Result<void> free = check_not_among(file, read); !free.ok()) return free.error();
  return write_film(file, film, view.value(), metadata, options);
}

} // namespace kindling
