// sft_msgc: writes the C++ header of one .msg file, and IDL for .idl files that include it.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "emit/emit.h"
#include "emit/output.h"
#include "from_msg/idl_text.h"
#include "from_msg/layouts.h"
#include "from_msg/model_of.h"
#include "from_msg/nested.h"
#include "from_msg/parse.h"

namespace {

namespace fs = std::filesystem;
using namespace sft::msg;

struct Arguments {
  std::string file;
  std::string base_dir;
  std::vector<std::string> roots;
  std::string output_dir = ".";
  std::string idl_dir;
  std::string dependency_file;
};

void declare(CLI::App& app, Arguments& arguments) {
  app.add_option("file", arguments.file, "The message: ROOT/PACKAGE/msg/NAME.msg")->required();
  app.add_option("-b", arguments.base_dir, "ROOT, if it is not the third directory above the file");
  app.add_option("-I", arguments.roots, "Another directory of packages with nested types; may be repeated")
      ->allow_extra_args(false);
  app.add_option("-o", arguments.output_dir, "Write the header to <dir>/PACKAGE/msg/NAME.hpp")
      ->capture_default_str();
  app.add_option("-i", arguments.idl_dir,
                 "Also write <dir>/PACKAGE/msg/NAME.idl, for .idl files that include it");
  app.add_option("-d", arguments.dependency_file,
                 "Write a make rule with the files that the header depends on to this file");
}

int fail(std::string_view file, std::uint32_t line, std::string_view place, std::string_view text) {
  fmt::print(stderr, "{}:{}: {}: {}\n", file, line, place, text);
  return 1;
}

int fail(const Arguments& arguments, const TypeName& type, const std::vector<Problem>& problems) {
  for (const Problem& problem : problems) {
    const std::string member = problem.member.empty() ? "" : "." + problem.member;
    const std::string column = problem.column == 0 ? "" : fmt::format("{}:", problem.column);
    fmt::print(stderr, "{}:{}:{} {}{}: {}\n", arguments.file, problem.line, column, type.text(), member,
               problem.text);
  }
  if (problems.size() >= Limits::problems) fmt::print(stderr, "{}: giving up\n", arguments.file);
  return 1;
}

/// The absolute path of a directory, without a trailing slash.
fs::path directory(const fs::path& path) {
  return (fs::absolute(path) / "").lexically_normal().parent_path();
}

bool is_name(const fs::path& name) {
  return std::distance(name.begin(), name.end()) == 3 && name.parent_path().filename() == "msg" &&
         name.extension() == ".msg" && *name.begin() != "..";
}

/// The definitions of nested messages, each read once.
class NestedDefinitions {
 public:
  explicit NestedDefinitions(const SearchPath& search_path) : search_path_(search_path) {}

  /// Null for types in IDL, and for messages with errors.
  const Definition* find(const TypeName& type) {
    const auto [known, is_new] = definitions_.try_emplace(type);
    const auto file = is_new ? search_path_.find(type) : std::nullopt;
    if (file && file->extension() == ".msg") {
      if (auto parsed = parse(read_file(*file), type)) known->second = *std::move(parsed);
    }
    return known->second ? &*known->second : nullptr;
  }

 private:
  const SearchPath& search_path_;
  std::map<TypeName, std::optional<Definition>> definitions_;
};

int generate(const Arguments& arguments, const fs::path& root, const TypeName& type) {
  const auto definition = parse(read_file(arguments.file), type);
  if (!definition) return fail(arguments, type, definition.error());
  std::vector<fs::path> roots{root};
  roots.insert(roots.end(), arguments.roots.begin(), arguments.roots.end());
  const SearchPath search_path(roots);
  const auto nested = nested_files(*definition, search_path);
  if (!nested) return fail(arguments, type, nested.error());
  NestedDefinitions definitions(search_path);
  const auto wrong = check_layouts(*definition, [&](const TypeName& name) { return definitions.find(name); });
  if (!wrong.empty()) return fail(arguments, type, wrong);

  if (!arguments.idl_dir.empty()) {
    const fs::path idl = fs::path(arguments.idl_dir) / (type.text() + ".idl");
    fs::create_directories(idl.parent_path());
    sft::idl::write_file(idl, idl_text(*definition));
  }
  const fs::path header = fs::path(arguments.output_dir) / (type.text() + ".hpp");
  fs::create_directories(header.parent_path());
  const ModelOf model(*definition, {root, *nested});
  const sft_output output{header.c_str(), arguments.dependency_file.c_str(), "", root.c_str()};
  return sft_emit(&model.file(), &output) ? 0 : 1;
}

int run(const Arguments& arguments) {
  const fs::path file = fs::absolute(arguments.file).lexically_normal();
  const fs::path root =
      directory(arguments.base_dir.empty() ? file.parent_path() / "../.." : fs::path(arguments.base_dir));
  const fs::path name = file.lexically_relative(root);
  if (file.extension() == ".srv" || file.extension() == ".action") {
    return fail(arguments.file, 1, name.string(),
                "services and actions are not supported: put each part into a .msg file");
  }
  if (!is_name(name)) {
    return fail(arguments.file, 1, name.string(),
                "this is no place for a message: expected PACKAGE/msg/NAME.msg below " + root.string());
  }
  return generate(arguments, root, {name.begin()->string(), name.stem().string()});
}

}  // namespace

int main(int argc, char** argv) try {
  Arguments arguments;
  CLI::App app("Makes the C++ header of a ROS 2 message.", "sft_msgc");
  declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  return run(arguments);
} catch (const std::exception& error) {
  fmt::print(stderr, "sft_msgc: {}\n", error.what());
  return 1;
}
