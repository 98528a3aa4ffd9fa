# Kernels for GPUs, compiled by Debian's clang-19 alone: no toolkit and no header of a vendor.
#
# Each source becomes bitcode; all of them are linked, optimized and translated together, so that
# functions of different sources are inlined. Without clang-19 Kindling has no kernels for GPUs.
# SPDX-License-Identifier: Apache-2.0
option(KINDLING_GPU "Compile kernels for GPUs, if clang++-19 is installed" ON)
if(KINDLING_GPU)
  find_program(KINDLING_CLANG_19 clang++-19)
else()
  unset(KINDLING_CLANG_19 CACHE)
endif()
find_path(KINDLING_IMATH_HEADERS ImathVec.h PATH_SUFFIXES Imath REQUIRED)
mark_as_advanced(KINDLING_IMATH_HEADERS KINDLING_CLANG_19)

# kindling_gpu_flags(VARIABLE CPU): options of clang-19 for the sources that kernels call. CPU:
# sm_70 and later of NVIDIA, gfx90a and others of AMD.
function(kindling_gpu_flags variable cpu)
  # The headers are those of the host's compiler.
  execute_process(COMMAND ${KINDLING_CLANG_19} -E -x c++ -v - INPUT_FILE /dev/null OUTPUT_QUIET ERROR_VARIABLE report)
  string(REGEX REPLACE ".*search starts here:\n(.*)End of search list.*" "\\1" folders "${report}")
  string(REGEX REPLACE "[ \n]+" ";" folders "${folders}")
  list(REMOVE_ITEM folders "")
  list(TRANSFORM folders PREPEND "-isystem")
  if(cpu MATCHES "^sm_")
    set(target --target=nvptx64-nvidia-cuda -Xclang -target-feature -Xclang +ptx62) # activemask
  else()
    # Imath's half.h includes headers of x86 unless CUDA compiles it.
    set(target --target=amdgcn-amd-amdhsa -nogpulib -D__CUDA_ARCH__=1)
  endif()
  set(${variable}
    ${target} -Xclang -target-cpu -Xclang ${cpu} -O3 -std=c++20 -ffp-contract=off -fno-math-errno
    -fno-trapping-math -fno-exceptions -fno-rtti -DNDEBUG -nostdinc ${folders} -isystem${KINDLING_IMATH_HEADERS} -I${PROJECT_SOURCE_DIR}
    # The host's C library asks for its processor. <iostream>, which Imath includes, has global
    # objects; its parts have none. <memory> has a loop that waits with an instruction of the host.
    -D__x86_64__ -D_GNU_SOURCE -D_GLIBCXX_IOSTREAM -include istream "-D__builtin_ia32_pause()=void()"
    PARENT_SCOPE)
endfunction()

# kindling_gpu_kernels(CPU ENTRIES LIST OUTPUT): makes the assembly of a source with entry points
# and of those in the file LIST; PTX for NVIDIA.
function(kindling_gpu_kernels cpu entries list output)
  kindling_gpu_flags(flags ${cpu})
  set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${list})
  file(STRINGS ${list} sources REGEX "^[^#]")
  set(link)
  set(all_bitcode)
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/gpu/${cpu})
  foreach(source IN LISTS sources)
    string(REPLACE "/" "_" name ${source})
    set(bitcode ${folder}/${name}.bc)
    add_custom_command(OUTPUT ${bitcode}
      COMMAND ${KINDLING_CLANG_19} ${flags} -MD -MF ${bitcode}.d -MT ${bitcode} -c -emit-llvm ${PROJECT_SOURCE_DIR}/renderer/${source} -o ${bitcode}
      DEPENDS ${PROJECT_SOURCE_DIR}/renderer/${source} DEPFILE ${bitcode}.d
      COMMENT "Compiling ${source} for ${cpu}" VERBATIM)
    list(APPEND all_bitcode ${bitcode})
    list(APPEND link -Xclang -mlink-bitcode-file -Xclang ${bitcode})
  endforeach()
  set(bounds)
  set(bound)
  if(cpu MATCHES "^sm_")
    set(bounds ${PROJECT_SOURCE_DIR}/renderer/device/kernels/launch_bounds.sed
               ${PROJECT_SOURCE_DIR}/renderer/device/kernels/divisions.sed)
    list(TRANSFORM bounds PREPEND -f OUTPUT_VARIABLE bound)
    set(bound COMMAND sed -E -i ${bound} ${output})
  endif()
  # One file of all sources, of which the entry points take what they call.
  file(MAKE_DIRECTORY ${folder})
  file(WRITE ${folder}/empty.cpp "")
  add_custom_command(OUTPUT ${folder}/sources.bc
    COMMAND ${KINDLING_CLANG_19} ${flags} -O0 -Xclang -disable-llvm-passes -c -emit-llvm ${folder}/empty.cpp ${link} -o ${folder}/sources.bc
    DEPENDS ${all_bitcode} VERBATIM COMMENT "Linking the sources for ${cpu}")
  add_custom_command(OUTPUT ${output}
    COMMAND ${KINDLING_CLANG_19} ${flags} -MD -MF ${output}.d -MT ${output} -S ${entries}
            -Xclang -mlink-builtin-bitcode -Xclang ${folder}/sources.bc -o ${output}
    ${bound}
    DEPENDS ${entries} ${bounds} ${folder}/sources.bc DEPFILE ${output}.d
    COMMENT "Compiling the kernels for ${cpu}" VERBATIM)
endfunction()
