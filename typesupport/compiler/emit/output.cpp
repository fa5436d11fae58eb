#include "output.h"

#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <string>
#include <system_error>

namespace sft::idl {

namespace fs = std::filesystem;

void write_file(const fs::path& path, std::string_view text) {
  const fs::path unfinished = path.string() + "." + std::to_string(getpid());
  std::ofstream out(unfinished, std::ios::binary);
  out << text;
  out.close();
  std::error_code error;
  if (!out) error.assign(errno, std::generic_category());
  if (!error) fs::rename(unfinished, path, error);
  if (!error) return;

  std::error_code ignored;
  fs::remove(unfinished, ignored);
  throw std::system_error(error, "cannot write " + path.string());
}

}  // namespace sft::idl
