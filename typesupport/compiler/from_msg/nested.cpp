#include "from_msg/nested.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <fstream>
#include <set>
#include <system_error>

#include "from_msg/parse.h"

namespace sft::msg {
namespace {

namespace fs = std::filesystem;

/// Visits the messages that a definition nests, depth first.
class Walk {
 public:
  Walk(const Definition& definition, const SearchPath& search_path)
      : definition_(definition), search_path_(search_path) {}

  tl::expected<std::vector<fs::path>, std::vector<Problem>> run() {
    for (const Field& field : definition_.fields) {
      if (field.type.kind != SFT_STRUCTURE) continue;
      field_ = &field;
      const TypeName& type = field.type.nested;
      if (!search_path_.find(type) && type != definition_.type) refuse_unknown(type);
      enter(type);
    }
    if (!problems_.empty()) return tl::unexpected(std::move(problems_));
    return std::move(files_);
  }

 private:
  void enter(const TypeName& type) {
    if (type == definition_.type) return refuse_recursion();
    if (chain_.size() == Limits::levels) {
      return refuse(fmt::format("messages are nested over more than {} levels", Limits::levels));
    }
    if (!visited_.insert(type).second) return;
    const auto file = search_path_.find(type);
    if (!file) return;
    files_.push_back(*file);
    if (file->extension() != ".msg") return;
    const auto nested = parse(read_file(*file), type);
    if (!nested) return;
    chain_.push_back(type);
    for (const TypeName& inner : nested_types(*nested)) enter(inner);
    chain_.pop_back();
  }

  void refuse_unknown(const TypeName& type) {
    std::string advice =
        "name the directory above the package as another root (-I; INCLUDES of sft_generate)";
    if (type.name == "Header" && type.package != "std_msgs") advice = "did you mean std_msgs/Header?";
    refuse(
        fmt::format("there is no {0}.msg or .idl below {1}: {2}", type.text(), search_path_.text(), advice));
  }

  void refuse_recursion() {
    std::string chain = definition_.type.text();
    for (const TypeName& type : chain_) chain += " > " + type.text();
    refuse(
        fmt::format("{} > {}: recursive types are not supported: hold all nodes in one sequence and refer "
                    "to them by index",
                    chain, definition_.type.text()));
  }

  void refuse(std::string text) { problems_.push_back({field_->line, field_->name, std::move(text)}); }

  const Definition& definition_;
  const SearchPath& search_path_;
  const Field* field_ = nullptr;
  std::vector<TypeName> chain_;
  std::set<TypeName> visited_;
  std::vector<fs::path> files_;
  std::vector<Problem> problems_;
};

}  // namespace

std::optional<fs::path> SearchPath::find(const TypeName& type) const {
  for (const fs::path& root : roots_) {
    for (const std::string& extension : {"." + type.folder, std::string(".idl")}) {
      fs::path file = root / (type.text() + extension);
      std::error_code ignored;
      if (fs::is_regular_file(file, ignored)) return file;
    }
  }
  return {};
}

std::string SearchPath::text() const {
  std::string result;
  for (const fs::path& root : roots_) result += (result.empty() ? "" : ", ") + root.string();
  return result;
}

std::vector<TypeName> nested_types(const Definition& definition) {
  std::vector<TypeName> types;
  for (const Field& field : definition.fields) {
    const bool is_new = std::ranges::find(types, field.type.nested) == types.end();
    if (field.type.kind == SFT_STRUCTURE && is_new) types.push_back(field.type.nested);
  }
  return types;
}

tl::expected<std::vector<fs::path>, std::vector<Problem>> nested_files(const Definition& definition,
                                                                       const SearchPath& search_path) {
  return Walk(definition, search_path).run();
}

std::string read_file(const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::string text;
  // One byte more than the limit is read, so that the parser notices a text that is too long.
  text.resize(Limits::bytes + 1);
  in.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (in.bad() || !in.is_open()) {
    throw std::system_error(errno, std::generic_category(), "cannot read " + path.string());
  }
  text.resize(static_cast<std::size_t>(in.gcount()));
  return text;
}

}  // namespace sft::msg
