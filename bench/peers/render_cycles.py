"""Renders one glTF scene with Cycles, in Blender or in Blender's Python module.

    blender -b --factory-startup --python-exit-code 1 -P render_cycles.py -- JOB.json
    PYTHON render_cycles.py JOB.json

PYTHON is that of the environment of install.py. The job is written by renderers.py. Settings are those that make a plain path tracer of Cycles: no denoising, no
clamps, no adaptive sampling, no glossy blur, no light threshold, caustics on, box filter, single-scatter GGX.
"""
# SPDX-License-Identifier: Apache-2.0
import json
import math
import os
import re
import sys
import time

import numpy

# The glTF importer of Blender 3.4 uses the alias that NumPy 1.24 dropped.
if not hasattr(numpy, "bool"):
    numpy.bool = bool

import bpy  # noqa: E402  (after the repair of numpy)

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))  # Blender runs scripts without their folder
import budget  # noqa: E402
import gltf_json  # noqa: E402


def principled_nodes(material):
    if material.use_nodes:
        for node in material.node_tree.nodes:
            if node.type == "BSDF_PRINCIPLED":
                yield node


def repair_materials(gltf):
    """Sets single-scatter GGX everywhere, and specular 0 for specularFactor 0, which the importer ignores."""
    without_specular = set()
    for material in gltf.get("materials", []):
        specular = material.get("extensions", {}).get("KHR_materials_specular", {})
        if specular.get("specularFactor", 1.0) == 0.0:
            without_specular.add(material.get("name"))
    for material in bpy.data.materials:
        name = material.name
        if name not in without_specular:
            name = re.sub(r"\.\d{3}$", "", name)  # Blender's suffix for a duplicate name
        for node in principled_nodes(material):
            node.distribution = "GGX"
            if name in without_specular:
                node.inputs["Specular" if "Specular" in node.inputs else "Specular IOR Level"].default_value = 0.0


def import_scene(path):
    """Imports a file. Lights keep their numbers, taken as watts, and have no size."""
    if "export_import_convert_lighting_mode" in bpy.ops.import_scene.gltf.get_rna_type().properties.keys():
        bpy.ops.import_scene.gltf(filepath=path, export_import_convert_lighting_mode="COMPAT")
    else:  # Blender 3.4 takes them as lumens
        bpy.ops.import_scene.gltf(filepath=path)
        for light in bpy.data.lights:
            light.energy *= 683.0
    for light in bpy.data.lights:
        if light.type == "SUN":
            light.angle = 0.0
        else:
            light.shadow_soft_size = 0.0


def set_world(job):
    """The equirectangular image, u = 0.5 + atan2(z, x) / 2 pi in glTF axes, which after the importer's rotation of +Y to +Z is
    exactly Blender's own mapping; a rotation turns it counter-clockwise seen from above. Without an image: black."""
    world = bpy.data.worlds.new("environment")
    bpy.context.scene.world = world
    world.use_nodes = True
    nodes, links = world.node_tree.nodes, world.node_tree.links
    background = nodes["Background"]
    if not job.get("environment"):
        background.inputs["Color"].default_value = (0.0, 0.0, 0.0, 1.0)
        return
    texture = nodes.new("ShaderNodeTexEnvironment")
    texture.image = bpy.data.images.load(job["environment"])
    texture.image.colorspace_settings.name = "Linear" if bpy.app.version < (4, 0) else "Linear Rec.709"
    texture.projection = "EQUIRECTANGULAR"
    coordinates = nodes.new("ShaderNodeTexCoord")
    mapping = nodes.new("ShaderNodeMapping")
    # The look-up direction turns against the environment.
    mapping.inputs["Rotation"].default_value = (0.0, 0.0, -math.radians(job.get("environment_rotation_deg", 0.0)))
    links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    links.new(mapping.outputs["Vector"], texture.inputs["Vector"])
    links.new(texture.outputs["Color"], background.inputs["Color"])
    background.inputs["Strength"].default_value = job.get("environment_intensity", 1.0)
    world.cycles.sampling_method = "AUTOMATIC"  # importance map at the resolution of the image
    world.cycles_visibility.camera = job.get("background_visible", True)


def set_cycles(job):
    scene = bpy.context.scene
    render, cycles = scene.render, scene.cycles
    render.engine = "CYCLES"
    render.threads_mode = "FIXED"
    render.threads = job["threads"]
    render.resolution_x, render.resolution_y = job["size_px"]
    render.resolution_percentage = 100
    render.pixel_aspect_x = render.pixel_aspect_y = 1.0
    render.use_border = False
    render.use_compositing = False
    render.use_sequencer = False
    render.film_transparent = False
    render.use_motion_blur = False
    render.use_persistent_data = False
    render.image_settings.file_format = "OPEN_EXR"
    render.image_settings.color_mode = "RGB"
    render.image_settings.color_depth = "32"
    render.image_settings.exr_codec = "ZIP"
    render.use_file_extension = False

    cycles.device = "CPU"
    cycles.samples = job["spp"]
    cycles.seed = job["seed"]
    cycles.use_animated_seed = False
    cycles.use_adaptive_sampling = False
    cycles.use_denoising = False
    cycles.time_limit = 0.0
    cycles.sample_clamp_direct = 0.0
    cycles.sample_clamp_indirect = 0.0
    cycles.blur_glossy = 0.0
    cycles.light_sampling_threshold = 0.0
    cycles.caustics_reflective = True
    cycles.caustics_refractive = True
    cycles.pixel_filter_type = "BOX"
    cycles.use_fast_gi = False
    cycles.film_exposure = 1.0
    cycles.max_bounces = job["max_bounces"]
    cycles.diffuse_bounces = job["max_bounces"]
    cycles.glossy_bounces = job["max_bounces"]
    cycles.transmission_bounces = job["max_bounces"]
    cycles.volume_bounces = 0
    cycles.transparent_max_bounces = 64
    scene.view_settings.exposure = 0.0


def set_camera(gltf, size_px):
    """Selects the first camera of the file; glTF's vertical angle of view holds for any aspect ratio."""
    cameras = [thing for thing in bpy.context.scene.objects if thing.type == "CAMERA"]
    if not cameras:
        sys.exit("render_cycles.py: the scene has no camera")
    camera = cameras[0]
    bpy.context.scene.camera = camera
    perspective = gltf["cameras"][0].get("perspective") if gltf.get("cameras") else None
    if perspective:
        camera.data.sensor_fit = "VERTICAL"
        camera.data.angle = perspective["yfov"]
    camera.data.clip_end = 1e6
    camera.data.dof.use_dof = False


def timed_render(samples, write, denoised=False):
    """Returns the seconds of a render on the clock, and of all threads."""
    cycles = bpy.context.scene.cycles
    cycles.samples = samples
    cycles.use_denoising = denoised
    if denoised:  # Open Image Denoise at its best, on the processor
        cycles.denoiser = "OPENIMAGEDENOISE"
        cycles.denoising_input_passes = "RGB_ALBEDO_NORMAL"
        cycles.denoising_prefilter = "ACCURATE"
        cycles.denoising_quality = "HIGH"
        cycles.denoising_use_gpu = False
    wall, cpu = time.perf_counter(), time.process_time()
    bpy.ops.render.render(write_still=write)
    return time.perf_counter() - wall, time.process_time() - cpu


def path_tracing_times(samples):
    """Renders one sample, then all: their difference leaves out what is no path tracing (synchronization, the BVH)."""
    one = timed_render(1, False)
    many = timed_render(samples, True)
    return [max(b - a, 1e-3) * samples / max(samples - 1, 1) for a, b in zip(one, many)]


def denoised_within(job):
    """Renders and denoises as many samples as path tracing and filter can have in the job's time."""
    clock = 1 if job["clock"] == "cpu" else 0
    fixed_s, sample_s, filter_s = budget.measure(lambda samples, denoised: timed_render(samples, False, denoised), clock)
    samples = budget.samples_within(job["budget_s"], sample_s, filter_s)
    total_s = timed_render(samples, True, True)[clock] - fixed_s
    return {"version": bpy.app.version_string, "spp": samples, "total_s": total_s, "filter_s": filter_s}


def main():
    with open(sys.argv[-1], encoding="utf-8") as file:
        job = json.load(file)
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.ops.preferences.addon_enable(module="cycles")
    bpy.ops.preferences.addon_enable(module="io_scene_gltf2")
    import_started = time.perf_counter()
    import_scene(job["scene"])
    import_s = time.perf_counter() - import_started
    gltf = gltf_json.read_json(job["scene"])
    repair_materials(gltf)
    set_world(job)
    set_cycles(job)
    set_camera(gltf, job["size_px"])
    bpy.context.scene.render.filepath = job["output"]
    if job.get("budget_s"):
        print("PEER-RESULT " + json.dumps(denoised_within(job)), flush=True)
        return
    if job.get("timed"):
        wall_s, cpu_s = path_tracing_times(job["spp"])
        print("PEER-RESULT " + json.dumps({"version": bpy.app.version_string, "wall_s": wall_s, "cpu_s": cpu_s}), flush=True)
        return
    render_started = time.perf_counter()
    print("KINDLING-RENDER-STARTS", flush=True)
    bpy.ops.render.render(write_still=True)
    render_s = time.perf_counter() - render_started
    print("KINDLING-RESULT " + json.dumps({
        "import_s": import_s, "render_call_s": render_s, "version": bpy.app.version_string,
        "sampling_pattern": bpy.context.scene.cycles.sampling_pattern}), flush=True)


main()
