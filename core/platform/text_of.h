// Reads the text of a file that may disappear meanwhile, such as the files of processes in /proc.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

namespace sft::core {

/// Returns as much of the file as could be read; the result is empty if there is no such file. The function
/// uses no iterator over the stream buffer, since an iterator would throw if the process of the file ends
/// meanwhile.
inline std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return std::move(text).str();
}

}  // namespace sft::core
