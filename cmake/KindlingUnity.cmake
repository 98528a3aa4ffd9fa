# What CMAKE_UNITY_BUILD, which the presets of the sanitizers set, must leave alone: it compiles sources of a folder together, eight at a
# time, in a third of the time. These have names in their anonymous namespaces, or macros, that another source of the folder has too, or classes whose
# members are of these namespaces (GCC takes an included source for a header).
# The Release build compiles every source alone, so that a missing include is found.
# SPDX-License-Identifier: Apache-2.0

# compile_alone(FOLDER TARGET sources...): relative to the folder.
function(compile_alone folder target)
  list(TRANSFORM ARGN PREPEND "${PROJECT_SOURCE_DIR}/${folder}/")
  if(TARGET ${target})
    set_source_files_properties(${ARGN} TARGET_DIRECTORY ${target} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
endfunction()

compile_alone(accel kindling_accel
  kdtree/instance_level.cpp kdtree/leaf_block.cpp kdtree/partition.cpp kdtree/split_bins.cpp kdtree/split_counted.cpp kdtree/kernels/avx2.cpp kdtree/kernels/avx512.cpp
  kdtree/kernels/divided_avx2.cpp kdtree/kernels/divided_avx512.cpp kdtree/kernels/divided_portable.cpp
  kdtree/kernels/moving_avx2.cpp kdtree/kernels/moving_avx512.cpp kdtree/kernels/moving_portable.cpp kdtree/kernels/portable.cpp)
compile_alone(renderer/image kindling_image
  decode_hdr.cpp decode_jpeg.cpp decode_ktx2.cpp decode_png.cpp decode_webp.cpp etc1s_codebooks.cpp ktx2_container.cpp)
compile_alone(renderer/texture kindling_texture procedural_emitter.cpp procedural_program.cpp)
compile_alone(renderer/guiding kindling_guiding share_tree.cpp)
compile_alone(renderer/light kindling_light build_light_tree.cpp whole_lights.cpp light_tree.cpp)
compile_alone(renderer/import kindling_import
  draco_mesh.cpp json_schema_tables.cpp kindling_extras.cpp light_extras.cpp meshopt_attributes.cpp parse_ies.cpp photometric_lights.cpp procedurals.cpp triangles.cpp
  tinygltf_core.cpp vertex_repair.cpp)
compile_alone(renderer/integrator kindling_integrator integrator.cpp)
compile_alone(renderer/session kindling_session accumulation_reader.cpp one_picture.cpp ray_file.cpp)
compile_alone(renderer/distributed kindling_distributed merge_frames.cpp work_parts.cpp)
compile_alone(renderer/world kindling_world prepare_geometry.cpp surface.cpp)
compile_alone(renderer/app kindling_app
  choose.cpp console.cpp farm_flags.cpp frame_flags.cpp lens_flags.cpp picture_metadata.cpp picture_settings.cpp progress_display.cpp
  progress_format.cpp render_flags.cpp render_stage.cpp shootout_html.cpp shootout_plots.cpp shootout_tables.cpp shutter_flags.cpp version.cpp)
