#include "tools/sft/definitions.h"

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <regex>
#include <system_error>
#include <vector>

#include "core/platform/text_file.h"

namespace sft::tool {

namespace {

namespace fs = std::filesystem;

/// Returns the directory with the messages of SFT. The directory is found by its path relative to the
/// program, so the installation can be at any place. The build tree has a link at the same relative path.
fs::path own_interfaces() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return (program.parent_path() / SFT_INTERFACES_FROM_PROGRAM).lexically_normal();
}

/// The limits of types in the user's own files. These files are not hostile, so their types may nest deeper
/// than types that other nodes announce.
constexpr DynamicType::Limits limits_of_files{.bytes = std::size_t{1} << 20, .depth = 64};

std::vector<fs::path> roots_of(const CommonOptions& common) {
  std::vector<fs::path> roots(common.includes.begin(), common.includes.end());
  roots.push_back(own_interfaces());
  return roots;
}

/// Returns the file of a message or service in the first directory that has it, or nothing if no directory
/// has it.
std::optional<fs::path> find_file(std::string_view name, const std::string& kind,
                                  const CommonOptions& common) {
  std::string path(name);
  for (std::size_t at = path.find("::"); at != path.npos; at = path.find("::")) path.replace(at, 2, "/");
  const std::size_t first = path.find('/'), last = path.rfind('/');
  if (first == path.npos || (first != last && path.substr(first, last - first) != "/" + kind)) return {};
  for (const fs::path& root : roots_of(common)) {
    fs::path file = root / path.substr(0, first) / kind / (path.substr(last + 1) + "." + kind);
    std::error_code ignored;
    if (fs::is_regular_file(file, ignored)) return file;
  }
  return {};
}

}  // namespace

Result<DynamicType> find_definition(const std::string& type, const CommonOptions& common) {
  const std::vector<fs::path> roots = roots_of(common);
  return type.ends_with(".msg") ? from_msg_file(type, roots, limits_of_files)
                                : find_msg(type, roots, limits_of_files);
}

Result<DynamicType> definition_of(const DomainSnapshot::Endpoint& endpoint, const CommonOptions& common) {
  return find_msg(endpoint.type_name, roots_of(common), limits_of_files)
      .and_then([&](const DynamicType& type) -> Result<DynamicType> {
        const std::string hash = endpoint.dds ? ros_type_hash(type).value_or("") : "";
        const bool is_it = !endpoint.dds ? type.hash() == endpoint.type_hash
                                         : hash.empty() || endpoint.dds->type_hash.empty() ||
                                               hash == endpoint.dds->type_hash;
        if (is_it && type.name() == endpoint.type_name) return type;
        return fail(Errc::type_mismatch,
                    "the files define another " + endpoint.type_name + " than node '" + endpoint.node +
                        "' has" +
                        (endpoint.dds ? " (" + hash + ", and there " + endpoint.dds->type_hash + ")" : "") +
                        ": name the directory of its definition first");
      });
}

std::string constants_of(const StructType& type, const CommonOptions& common) {
  const std::optional<fs::path> file = find_file(type.name, "msg", common);
  const auto defined = file ? find_definition(std::string(type.name), common) : fail(Errc::unavailable, "");
  if (!defined || defined->hash() != TypeSupport(type).hash()) return "";
  static const std::regex constant(R"(\s*[A-Za-z][\w/]*(<=\d+)?\s+[A-Za-z]\w*\s*=.*)");
  std::string text;
  std::ifstream lines(*file);
  for (std::string line; std::getline(lines, line);)
    if (std::regex_match(line, constant)) text += line + "\n";
  return text;
}

std::optional<std::string> find_service(std::string_view service, const CommonOptions& common) {
  const std::optional<fs::path> file =
      service.ends_with(".srv") ? fs::path(service) : find_file(service, "srv", common);
  const auto text = file ? core::read_text_file(*file) : fail(Errc::unavailable, "");
  return text ? std::optional(*text) : std::nullopt;
}

}  // namespace sft::tool
