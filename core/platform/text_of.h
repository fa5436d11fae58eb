// Reads the text of a file that may disappear while it is read, as those of processes in /proc do.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

namespace sft::core {

/// Returns as much of the file as could be read; empty if there is no such file. It uses no iterator over the
/// stream buffer, since that would throw if the process of the file ends meanwhile.
inline std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return std::move(text).str();
}

}  // namespace sft::core
