// The text of a file that may vanish while it is read, as those of processes in /proc do.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <utility>

namespace sft::core {

/// Returns as much of the file as could be read: nothing if the file is not there. Where a process ends
/// meanwhile, an iterator over the buffer of the stream would throw.
inline std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return std::move(text).str();
}

}  // namespace sft::core
