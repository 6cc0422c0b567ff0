// These functions run Debian's Python on files that the library wrote, with the code blocks of the documents.
#pragma once
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace viewpeel {

struct PythonResult {
  int status;
  std::string output;  // stdout and stderr
};

// Runs a script in the folder, with Debian's interpreter, which finds Debian's modules.
inline PythonResult runPython(const std::filesystem::path& folder, const std::string& script) {
  const std::filesystem::path file = folder / "script.py";
  std::ofstream(file) << script;
  const std::string command = "cd '" + folder.string() + "' && /usr/bin/python3 -B -W ignore script.py 2>&1 </dev/null";
  FILE* pipe = popen(command.c_str(), "r");
  PythonResult result{-1, ""};
  std::array<char, 4096> buffer;
  while (size_t got = fread(buffer.data(), 1, buffer.size(), pipe)) result.output.append(buffer.data(), got);
  const int status = pclose(pipe);
  result.status = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

// Returns the Python block of a document that begins with `# TITLE`, or an empty string.
inline std::string pythonBlock(const std::string& document, const std::string& title) {
  std::ifstream in(document);
  std::string block;
  bool is_inside = false;
  for (std::string line; std::getline(in, line);) {
    if (!is_inside) {
      if (line == "```python" && std::getline(in, line) && line == "# " + title) is_inside = true;
      continue;
    }
    if (line == "```") return block;
    block += line + "\n";
  }
  return "";
}

}  // namespace viewpeel
