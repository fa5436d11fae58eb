#include "tools/sft/definitions.h"

#include <cstddef>
#include <filesystem>
#include <system_error>
#include <vector>

namespace sft::tool {

namespace {

namespace fs = std::filesystem;

/// Returns the directory with the messages of SFT. Its path is relative to the program, wherever that is
/// installed. The build tree has a link there.
fs::path own_interfaces() {
  std::error_code error;
  const fs::path program = fs::read_symlink("/proc/self/exe", error);
  return (program.parent_path() / SFT_INTERFACES_FROM_PROGRAM).lexically_normal();
}

/// The user's own files are not hostile. So types in them may nest deeper than those that other nodes
/// announce.
constexpr DynamicType::Limits limits_of_files{.bytes = std::size_t{1} << 20, .depth = 64};

std::vector<fs::path> roots_of(const CommonOptions& common) {
  std::vector<fs::path> roots(common.includes.begin(), common.includes.end());
  roots.push_back(own_interfaces());
  return roots;
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
        if (type.hash() == endpoint.type_hash && type.name() == endpoint.type_name) return type;
        return fail(Errc::type_mismatch, "the files define another " + endpoint.type_name + " than node '" +
                                             endpoint.node +
                                             "' has: name the directory of its definition first");
      });
}

}  // namespace sft::tool
