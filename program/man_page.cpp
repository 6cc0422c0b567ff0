#include <algorithm>

#include <fmt/format.h>

#include "program/completion.h"
#include "program/examples.h"
#include "program/help.h"

namespace viewpeel::program {
namespace {

// Escapes the characters that roff would interpret: backslashes, hyphens and quotes. A dot is escaped at the start of
// every word, since wrapping may put the word at the start of a line.
std::string escapeRoff(const std::string& text) {
  std::string escaped;
  for (char c : text)
    if (c == '.' && (escaped.empty() || escaped.back() == ' ')) escaped += "\\&.";
    else if (c == '\\') escaped += "\\e";
    else if (c == '-') escaped += "\\-";
    else if (c == '\'') escaped += "\\(aq";
    else escaped += c;
  return escaped;
}

std::string paragraph(const std::string& text) { return wrap(escapeRoff(text), 0, 0); }

// Returns an entry of a list: terms in bold, their value in italics, and a text.
std::string entry(const std::vector<std::string>& terms, const std::string& value, const std::string& text) {
  std::string line;
  for (const std::string& term : terms) line += (line.empty() ? "\\fB" : ", \\fB") + escapeRoff(term) + "\\fR";
  if (!value.empty()) line += " \\fI" + escapeRoff(value) + "\\fR";
  return fmt::format(".TP\n{}\n{}\n", line, paragraph(text));
}

std::string describeInManual(const CommandEntry& command) {
  std::string text = fmt::format(".SS \"viewpeel {}\"\n{}.\n.PP\n.B {}\n", command.name, paragraph(command.text),
                                 escapeRoff(command.usage()));
  for (const OptionEntry& positional : command.positionals) text += entry(positional.names, "", positional.text);
  for (const OptionGroup& group : command.groups) {
    text += fmt::format(".PP\n.I {}\n", group.title);
    for (const OptionEntry& option : group.options) text += entry(option.names, option.value, option.text);
  }
  return text;
}

std::string exemplify(const std::string& command) {
  std::string text;
  for (const Example& example : examplesOf(command))
    text += entry({example.line}, "", std::string(example.purpose) + ".");
  return text;
}

constexpr const char* kDescription = R"(.SH DESCRIPTION
The form factor (view factor) from polygon i to polygon j is the fraction of
the diffuse radiation leaving i that directly reaches j.
.B viewpeel
computes the form factors of every pair of polygons of a scene at once, with
occlusion, and states an error for each.
It does so on the processor or on a Vulkan device.
.PP
A file in place of a command is a scene to compute.
Called by its second name,
.BR view3d ,
the program takes the place of View3D: it reads the .vs3 file and writes the
file that its two arguments name.
)";

struct Row {
  const char *term, *text;
};

constexpr Row kStatuses[] = {
    {"0", "Done."},
    {"1", "Failed: a device, memory, an output at the end, or check found a difference."},
    {"2", "Wrong usage or input; one line on standard error says what and where."},
    {"3",
     "The goal was not reached before --seconds were over, or in many times the planned replicates; the results so far "
     "are written."},
    {"129, 130, 143", "Stopped by SIGHUP, SIGINT, SIGTERM; the results so far are written."},
};

constexpr Row kEnvironmentVariables[] = {
    {"VIEWPEEL_DEVICE", "As --device, which overrides it."},
    {"VIEWPEEL_VALIDATION", "If 1, the Vulkan validation layer is on; a message of it is an error."},
};

}  // namespace

std::string manPage(const CommandEntry& program) {
  std::string text =
      fmt::format(".TH VIEWPEEL 1 \"{}\" \"viewpeel {}\" \"User Commands\"\n", VIEWPEEL_DATE, VIEWPEEL_VERSION);
  text += ".SH NAME\nviewpeel \\- form factors of polygonal scenes with occlusion, with a stated error\n";
  text += ".SH SYNOPSIS\n";
  for (const CommandEntry& command : program.commands) text += fmt::format(".B {}\n.br\n", escapeRoff(command.usage()));
  text += ".B viewpeel \\-\\-help | \\-\\-version\n";
  text += kDescription;
  text += ".SH COMMANDS\n";
  for (const CommandEntry& command : program.commands) text += describeInManual(command);
  text += ".SH \"EXIT STATUS\"\n";
  for (const auto& [status, meaning] : kStatuses) text += entry({status}, "", meaning);
  text += ".SH ENVIRONMENT\n";
  for (const auto& [variable, effect] : kEnvironmentVariables) text += entry({variable}, "", effect);
  text += ".SH EXAMPLES\n";
  text += exemplify(program.name);
  for (const CommandEntry& command : program.commands) text += exemplify(command.name);
  text +=
      ".SH \"SEE ALSO\"\nM. Pellegrini,\n.IR \"Monte Carlo approximation of form factors with error bounded a priori\" "
      ",\n"
      "Discrete & Computational Geometry 17 (1997), 319\\-337.\n";
  return text;
}

}  // namespace viewpeel::program
