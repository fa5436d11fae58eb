#include "paths.h"

#include <fmt/format.h>

#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace sft::idl {

namespace fs = std::filesystem;

Roots::Roots(const char* list, const char* base_dir, const fs::path& main_file) {
  if (base_dir != nullptr) roots_.emplace_back(base_dir);
  std::istringstream listed(list);
  for (std::string root; std::getline(listed, root, ':');)
    roots_.push_back(fs::absolute(root).lexically_normal());
  if (roots_.empty()) roots_.push_back(main_file.parent_path());
}

fs::path Roots::relative(const fs::path& file) const {
  std::optional<fs::path> shortest;
  for (const fs::path& root : roots_) {
    fs::path below = file.lexically_relative(root);
    if (below.empty() || *below.begin() == "..") continue;
    if (!shortest || std::ranges::distance(below) < std::ranges::distance(*shortest))
      shortest = std::move(below);
  }
  if (shortest) return *shortest;
  throw std::runtime_error(
      fmt::format("{} is below no include root: name a directory above it with -r", file.string()));
}

}  // namespace sft::idl
