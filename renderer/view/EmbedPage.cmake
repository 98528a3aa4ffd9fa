# Writes a C++ source with the files of the page.
#
# cmake -DOUTPUT=page_files.cpp "-DFILES=a;b" -P EmbedPage.cmake
# SPDX-License-Identifier: Apache-2.0
set(types_html "text/html; charset=utf-8")
set(types_css "text/css; charset=utf-8")
set(types_js "text/javascript; charset=utf-8")
set(types_svg "image/svg+xml")
set(entries)
foreach(file IN LISTS FILES)
  file(READ ${file} text)
  get_filename_component(name ${file} NAME)
  get_filename_component(extension ${file} LAST_EXT)
  string(SUBSTRING ${extension} 1 -1 extension)
  string(FIND "${text}" ")page_file\"" end)
  if(NOT end EQUAL -1 OR NOT DEFINED types_${extension})
    message(FATAL_ERROR "${file} cannot be embedded")
  endif()
  string(APPEND entries "    {\"${name}\", \"${types_${extension}}\", R\"page_file(${text})page_file\"},\n")
endforeach()
file(WRITE ${OUTPUT} "// Made by EmbedPage.cmake.
#include \"renderer/view/page_files.h\"

namespace kindling {

namespace {

constexpr PageFile kPageFiles[] = {
${entries}};

} // namespace

std::span<const PageFile> page_files() { return kPageFiles; }

} // namespace kindling
")
