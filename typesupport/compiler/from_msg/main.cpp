// The program sft_msgc. It writes the C++ header of one .msg or .srv file, and IDL for .idl files that
// include the message.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <map>
#include <memory>
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
#include "from_msg/service.h"

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
  std::string outer_namespace;
};

void declare(CLI::App& app, Arguments& arguments) {
  app.add_option("file", arguments.file,
                 "The message: ROOT/PACKAGE/msg/NAME.msg, or the service: ROOT/PACKAGE/srv/NAME.srv")
      ->required();
  app.add_option("-b", arguments.base_dir, "ROOT, if it is not the third directory above the file");
  app.add_option("-I", arguments.roots, "Another directory of packages with nested types; may be repeated")
      ->allow_extra_args(false);
  app.add_option("-o", arguments.output_dir,
                 "Write the header to <dir>/PACKAGE/msg/NAME.hpp or .../srv/NAME.hpp")
      ->capture_default_str();
  app.add_option("-i", arguments.idl_dir,
                 "Also write <dir>/PACKAGE/msg/NAME.idl of a message, for .idl files that include it");
  app.add_option("-d", arguments.dependency_file,
                 "Write a make rule with the files that the header depends on to this file");
  app.add_option("-N", arguments.outer_namespace,
                 "Put all into this namespace, as my::robot. Nested messages are included as "
                 "<my/robot/PACKAGE/msg/NAME.hpp>, so let the directory of -o end with my/robot");
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

/// Returns the absolute path of a directory, without a trailing slash.
fs::path directory(const fs::path& path) {
  return (fs::absolute(path) / "").lexically_normal().parent_path();
}

/// Returns the name of the message or service in a file, whose path is relative to its root.
std::optional<TypeName> name_of(const fs::path& file) {
  if (std::distance(file.begin(), file.end()) != 3 || *file.begin() == "..") return {};
  TypeName type{file.begin()->string(), file.stem().string(), file.parent_path().filename().string()};
  const bool is_known = type.folder == "msg" || type.folder == "srv";
  return is_known && file.extension() == "." + type.folder ? std::optional(std::move(type)) : std::nullopt;
}

/// Returns the definitions in a file: that of a message, or those of a service.
tl::expected<std::vector<Definition>, std::vector<Problem>> parse_file(const std::string& file,
                                                                       const TypeName& type) {
  if (type.folder == "srv") return parse_service(read_file(file), type);
  return parse(read_file(file), type).map([](Definition&& only) { return std::vector{std::move(only)}; });
}

/// The definitions of nested messages. Each file is read only once.
class NestedDefinitions {
 public:
  explicit NestedDefinitions(const SearchPath& search_path) : search_path_(search_path) {}

  /// Returns the definition; null for types in IDL, and for messages with errors.
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

/// Returns the files that the definitions nest, each once. If there are errors, prints them and returns
/// nothing.
std::optional<std::vector<fs::path>> check(const Arguments& arguments, const TypeName& type,
                                           const std::vector<Definition>& definitions,
                                           const SearchPath& search_path) {
  NestedDefinitions known(search_path);
  std::vector<fs::path> files;
  std::vector<Problem> problems;
  for (const Definition& definition : definitions) {
    const auto nested = nested_files(definition, search_path);
    const auto wrong = nested
                           ? check_layouts(definition, [&](const TypeName& name) { return known.find(name); })
                           : nested.error();
    problems.insert(problems.end(), wrong.begin(), wrong.end());
    if (nested) files.insert(files.end(), nested->begin(), nested->end());
  }
  if (!problems.empty()) return fail(arguments, type, problems), std::nullopt;
  std::ranges::sort(files);
  files.erase(std::ranges::unique(files).begin(), files.end());
  return files;
}

int generate(const Arguments& arguments, const fs::path& root, const TypeName& type) {
  const auto definitions = parse_file(arguments.file, type);
  if (!definitions) return fail(arguments, type, definitions.error());
  std::vector<fs::path> roots{root};
  roots.insert(roots.end(), arguments.roots.begin(), arguments.roots.end());
  const bool is_service = type.folder == "srv";
  // The last two definitions of a service are messages that carry the first two, so they need no check.
  const auto nested =
      check(arguments, type, {definitions->begin(), is_service ? definitions->end() - 2 : definitions->end()},
            SearchPath(roots));
  if (!nested) return 1;

  if (!arguments.idl_dir.empty() && !is_service) {
    const fs::path idl = fs::path(arguments.idl_dir) / (type.text() + ".idl");
    fs::create_directories(idl.parent_path());
    sft::idl::write_file(idl, idl_text(definitions->front()));
  }
  const fs::path header = fs::path(arguments.output_dir) / (type.text() + ".hpp");
  fs::create_directories(header.parent_path());
  const Files files{root, *nested};
  const auto model = is_service ? std::make_unique<ModelOf>(type, *definitions, files)
                                : std::make_unique<ModelOf>(definitions->front(), files);
  const sft_output output{header.c_str(), arguments.dependency_file.c_str(), "", root.c_str(),
                          arguments.outer_namespace.c_str()};
  return sft_emit(&model->file(), &output) ? 0 : 1;
}

int run(const Arguments& arguments) {
  const fs::path file = fs::absolute(arguments.file).lexically_normal();
  const fs::path root =
      directory(arguments.base_dir.empty() ? file.parent_path() / "../.." : fs::path(arguments.base_dir));
  const fs::path name = file.lexically_relative(root);
  if (file.extension() == ".action") {
    return fail(arguments.file, 1, name.string(),
                "actions are not supported: use a service for goals, and topics for feedback and results");
  }
  if (const auto type = name_of(name)) return generate(arguments, root, *type);
  return fail(arguments.file, 1, name.string(),
              "this is no place for a message: expected PACKAGE/msg/NAME.msg or PACKAGE/srv/NAME.srv below " +
                  root.string());
}

}  // namespace

int main(int argc, char** argv) try {
  Arguments arguments;
  CLI::App app("Makes the C++ header of a ROS 2 message or service.", "sft_msgc");
  declare(app, arguments);
  CLI11_PARSE(app, argc, argv);
  return run(arguments);
} catch (const std::exception& error) {
  fmt::print(stderr, "sft_msgc: {}\n", error.what());
  return 1;
}
