// The manual page as troff source.
// SPDX-License-Identifier: Apache-2.0
#include "renderer/app/flags/manual_page.h"

#include <fmt/format.h>

namespace kindling::app {

namespace {

// Text of a line: no character is taken for a request or an escape, and hyphens stay the ASCII
// ones.
std::string escape(std::string_view text) {
  std::string escaped;
  for (const char c : text) {
    if (c == '\\')
      escaped += "\\e";
    else if (c == '-')
      escaped += "\\-";
    else if (c == '\n')
      escaped += ' ';
    else
      escaped += c;
  }
  if (escaped.starts_with('.') || escaped.starts_with('\'')) escaped.insert(0, "\\&");
  return escaped;
}

std::string flag_entry(const FlagRow& flag) {
  std::string head = flag.short_name.empty() ? "" : fmt::format("\\fB{}\\fR, ", escape(flag.short_name));
  head += fmt::format("\\fB{}\\fR", escape(flag.long_name));
  if (!flag.label.empty()) head += fmt::format(" \\fI{}\\fR", escape(flag.label));
  return fmt::format(".TP\n{}\n{}\n", head, escape(flag.description));
}

std::string command_section(const CommandTable& command) {
  std::string text = fmt::format(".SS kindling {}\n{}\n.PP\n\\fBkindling {}\\fR {}\n", escape(command.name),
                                 escape(command.description), escape(command.name), escape(command.usage));
  std::string group;
  for (const FlagRow& flag : command.flags) {
    if (flag.group != group) text += fmt::format(".PP\n\\fI{}\\fR\n", escape(group = flag.group));
    text += flag_entry(flag);
  }
  return text;
}

constexpr std::string_view kEnd = R"(.SH EXIT STATUS
.TP
\fB0\fR
done
.TP
\fB1\fR
the render failed, or this processor cannot run the program
.TP
\fB2\fR
wrong usage
.TP
\fB3\fR
the scene is invalid
.TP
\fB4\fR
a file cannot be read or written
.TP
\fB5\fR
parts are missing
.TP
\fB6\fR
a farm is still at work
.TP
\fB129\fR, \fB130\fR, \fB143\fR
interrupted by SIGHUP, SIGINT or SIGTERM; the images and the checkpoint are written
.SH ENVIRONMENT
.TP
\fBKINDLING_OIDN\fR
The library of Open Image Denoise for \fB\-\-denoise\fR, or a folder that has it.
.TP
\fBOCIO\fR
The OpenColorIO configuration where \fB\-\-ocio\fR names none.
.SH EXAMPLES
.TP
\fBkindling render scene.glb \-o image.png\fR
Renders an image with the defaults.
.TP
\fBkindling render scene.glb \-\-spp 4096 \-o image.exr \-\-checkpoint\fR
Renders with checkpoints; after an interruption, the same command or \fBkindling resume\fR continues.
.TP
\fBkindling shootout scene.glb \-\-html race.html\fR
Races the kd\-tree against Embree on the rays of the scene.
)";

} // namespace

std::string manual_page(std::span<const CommandTable> commands, std::string_view version) {
  std::string text = fmt::format(".TH KINDLING 1 \"\" \"kindling {}\" \"User Commands\"\n.SH NAME\nkindling \\- path "
                                 "tracer for glTF 2.0 scenes\n.SH SYNOPSIS\n",
                                 escape(version));
  for (const CommandTable& command : commands)
    text += fmt::format(".B kindling {}\n{}\n.br\n", escape(command.name), escape(command.usage));
  text += ".SH DESCRIPTION\nKindling renders glTF scenes to PNG, JPEG and EXR images, races ray accelerators, and "
          "measures how rendering scales with threads and machines. Results go to standard output, messages to "
          "standard error. [Defaults] are in brackets; the last use of a flag counts.\n.SH COMMANDS\n";
  for (const CommandTable& command : commands) text += command_section(command);
  return text + std::string(kEnd);
}

} // namespace kindling::app
