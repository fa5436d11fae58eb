#include "sft/msg_text.h"

#include <algorithm>
#include <deque>
#include <map>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "from_msg/layouts.h"
#include "from_msg/lines.h"
#include "from_msg/names.h"
#include "from_msg/nested.h"
#include "from_msg/parse.h"
#include "from_msg/service.h"
#include "from_msg/type.h"
#include "layout/rule.h"
#include "sft/detail/text.h"
#include "sft/detail/type_description.h"

namespace sft {

using namespace detail;

namespace {

using msg::Definition;
using msg::TypeName;

constexpr std::string_view placeholder =
    "structure_needs_at_least_one_member";  // name of the member of a message without fields
constexpr std::string_view head_of_part = "MSG: ";
constexpr std::size_t separator_width = 80;
constexpr std::size_t unit_bytes_max = 255;

static_assert(static_cast<int>(SFT_STRUCTURE) == static_cast<int>(Kind::structure));

/// Returns the service to which this message belongs, such as "SetBool" for "SetBool_Call"; nothing if the
/// message belongs to no service.
std::optional<TypeName> service_of(const TypeName& name) {
  for (const std::string_view part : {"_Request", "_Response", "_Call", "_Reply"}) {
    if (name.folder == "srv" && name.name.ends_with(part))
      return TypeName{name.package, name.name.substr(0, name.name.size() - part.size()), name.folder};
  }
  return {};
}

/// Parses a name like "pkg/Name", "pkg/msg/Name", "pkg::msg::Name" or "pkg/srv/Name_Call".
std::optional<TypeName> type_name(std::string_view text) {
  std::string path(text);
  for (std::size_t at = path.find("::"); at != path.npos; at = path.find("::")) path.replace(at, 2, "/");
  const std::size_t first = path.find('/');
  const std::size_t last = path.rfind('/');
  if (first == path.npos) return {};
  const std::string_view between = std::string_view(path).substr(first, last - first);
  TypeName name{path.substr(0, first), path.substr(last + 1), between == "/srv" ? "srv" : "msg"};
  const std::optional<TypeName> service = service_of(name);
  const bool is_good = (between.empty() || between == "/msg" || service) &&
                       msg::is_package_name(name.package) &&
                       msg::is_message_name(service ? service->name : name.name);
  return is_good ? std::optional(std::move(name)) : std::nullopt;
}

/// Writes message types as .msg text.
class MsgWriter {
 public:
  Result<std::string> write(const StructType& root) {
    queue_.push_back(&root);
    for (std::size_t i = 0; i < queue_.size() && fault_.empty(); ++i) {
      const StructType& type = *queue_[i];
      const auto name = message_name(type);
      if (!name) {
        refuse(type, "is not the name of a message: .msg has names like my_msgs::msg::Status");
        break;
      }
      if (i > 0)
        text_ += std::string(separator_width, '=') + "\n" + std::string(head_of_part) + spelled(*name) + "\n";
      members(type);
    }
    if (!fault_.empty()) return fail(Errc::invalid_argument, fault_);
    return std::move(text_);
  }

 private:
  static std::optional<TypeName> message_name(const StructType& type) {
    return type.name.find("::msg::") == type.name.npos ? std::nullopt : type_name(type.name);
  }
  static std::string spelled(const TypeName& name) { return name.package + "/" + name.name; }

  void members(const StructType& type) {
    if (type.members.size() == 1 && type.members[0].name == placeholder) return;
    for (const Member& m : type.members) member(type, m);
  }

  void member(const StructType& type, const Member& m) {
    const std::string path = "." + std::string(m.name);
    if (!msg::is_field_name(m.name)) {
      return refuse(type, path + ": .msg has fields of lower-case letters, digits and single underscores");
    }
    if (m.enumeration != nullptr) return refuse(type, path + ": .msg has no enumerations and bitmasks");
    if (m.kind == Kind::character) return refuse(type, path + ": .msg has no characters, but uint8");
    if (m.key) return refuse(type, path + ": .msg has no keys");
    text_ += element(m) + brackets(m) + " " + std::string(m.name) + comment(m) + "\n";
  }

  std::string element(const Member& m) {
    if (m.kind == Kind::structure) {
      if (std::find(queue_.begin(), queue_.end(), m.type) == queue_.end()) queue_.push_back(m.type);
      const auto name = message_name(*m.type);
      return name ? spelled(*name) : "?";  // the error is reported when the nested message is written
    }
    const std::string bound = m.string_bound == 0 ? "" : "<=" + std::to_string(m.string_bound);
    return std::string(msg::spelling_of(static_cast<sft_kind>(m.kind))) + bound;
  }

  static std::string brackets(const Member& m) {
    if (m.shape == Shape::single) return "";
    if (m.shape == Shape::array) return "[" + std::to_string(m.count) + "]";
    return m.bound == 0 ? "[]" : "[<=" + std::to_string(m.bound) + "]";
  }

  /// Returns a comment with the layout, and with the unit if a comment can hold it.
  static std::string comment(const Member& m) {
    const bool has_unit = !m.unit.empty() && m.unit.find_first_of("[],") == m.unit.npos &&
                          m.unit.find(layout::annotation) == m.unit.npos;
    std::string text = has_unit ? " [" + std::string(m.unit) + "]" : "";
    if (!m.layout.empty()) text += " " + std::string(layout::annotation) + " " + std::string(m.layout);
    return text.empty() ? "" : "  #" + text;
  }

  void refuse(const StructType& type, const std::string& what) {
    if (fault_.empty()) fault_ = std::string(type.name) + (what.starts_with('.') ? "" : " ") + what;
  }

  std::vector<const StructType*> queue_;  // each type once, in the order of the text
  std::string text_;
  std::string fault_;
};

// ---- from text ----

/// Reads the definitions of one text or of files, and makes types from them.
class MsgReader {
 public:
  MsgReader() = default;
  /// Makes a reader that searches `search_path` for types that no text defines.
  explicit MsgReader(msg::SearchPath search_path) : search_path_(std::move(search_path)) {}

  /// Reads a text that begins with the definition of `root`, followed by other definitions. Returns the
  /// first error, or nothing.
  std::optional<Error> read(const TypeName& root, std::string_view text) {
    TypeName name = root;
    std::size_t begin = 0;
    for (std::size_t at = 0; at < text.size();) {
      const std::string_view line = line_at(text, at);
      const std::size_t next = at + line.size() + 1;
      if (is_separator(line)) {
        if (auto wrong = add(name, text.substr(begin, at - begin))) return wrong;
        const std::string_view head =
            msg::trimmed(without_return(line_at(text, std::min(next, text.size()))));
        const auto named = head.starts_with(head_of_part) ? type_name(head.substr(head_of_part.size()))
                                                          : std::optional<TypeName>();
        if (!named) {
          return Error{
              Errc::malformed,
              "behind a line of '=' a line 'MSG: package/Name' was expected, not '" + shown(head) + "'"};
        }
        name = *named;
        begin = std::min(next + line_at(text, std::min(next, text.size())).size() + 1, text.size());
        at = begin;
      } else {
        at = next;
      }
    }
    return add(name, text.substr(std::min(begin, text.size())));
  }

  Result<const StructType*> type_of(const TypeName& name) {
    if (const auto known = types_.find(name); known != types_.end()) return &known->second.type;
    if (auto wrong = look_for(name)) return tl::unexpected(*std::move(wrong));
    const auto definition = definitions_.find(name);
    if (definition == definitions_.end()) {
      return fail(Errc::malformed, name.text() +
                                       " is not defined: append its definition, behind a line of '=' "
                                       "and a line 'MSG: " +
                                       name.package + "/" + name.name + "'");
    }
    if (std::find(chain_.begin(), chain_.end(), name) != chain_.end())
      return fail(Errc::malformed, name.text() + " contains itself");
    if (chain_.size() >= msg::Limits::levels) {
      return fail(Errc::limit_exceeded,
                  "messages are nested over more than " + std::to_string(msg::Limits::levels) + " levels");
    }
    chain_.push_back(name);
    std::vector<Member> members;
    std::deque<std::string> layouts;
    for (const msg::Field& field : definition->second.definition.fields) {
      Member& m = members.emplace_back(member_of(field));
      if (!field.layout.text.empty()) m.layout = layouts.emplace_back(layout_text(field));
      if (m.kind != Kind::structure) continue;
      const Result<const StructType*> nested = type_of(field.type.nested);
      if (!nested) return nested;
      m.type = *nested;
    }
    chain_.pop_back();
    if (auto wrong = check_layouts_of(definition->second)) return tl::unexpected(*std::move(wrong));
    Made& made = types_[name];
    made.name = name.package + "::" + name.folder + "::" + name.name;
    made.members = std::move(members);
    made.layouts = std::move(layouts);
    made.type = StructType(made.name, made.members);
    return &made.type;
  }

 private:
  struct Made {  ///< must not be moved, since `type` refers to the other members
    std::string name;
    std::vector<Member> members;
    std::deque<std::string> layouts;  ///< the texts of the members' layout rules
    StructType type;
  };
  struct Known {
    Definition definition;
    std::string source;  ///< the name of the source for error messages
  };

  static std::string_view line_at(std::string_view text, std::size_t at) {
    return text.substr(at, std::min(text.find('\n', at), text.size()) - at);
  }
  static std::string_view without_return(std::string_view line) {
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }
  static bool is_separator(std::string_view line) {
    line = without_return(line);
    return line.size() >= 3 && line.find_first_not_of('=') == line.npos;
  }
  static std::string shown(std::string_view text) {
    constexpr std::size_t most = 60;
    return is_printable(text) ? std::string(text.substr(0, most)) : "something unprintable";
  }

  /// Reads the file of a type that is not defined yet, if there is a search path.
  std::optional<Error> look_for(const TypeName& name) {
    if (!search_path_ || definitions_.contains(name)) return {};
    const std::optional<TypeName> service = service_of(name);
    const TypeName defined = service.value_or(name);
    const auto file = search_path_->find(defined);
    if (!file) {
      return Error{Errc::unavailable, "there is no " + defined.text() + "." + defined.folder + " below " +
                                          search_path_->text() +
                                          ": name the directory above its package, too"};
    }
    if (file->extension() == ".idl") {
      return Error{Errc::unavailable, file->string() +
                                          " is IDL, which a running program cannot read: use a ." +
                                          defined.folder + " file"};
    }
    try {
      const std::string text = msg::read_file(*file);
      return service ? add_service(*service, text, file->string()) : add(name, text, file->string());
    } catch (const std::system_error& error) {
      return Error{Errc::unavailable, error.what()};
    }
  }

  std::optional<Error> add(const TypeName& name, std::string_view text) {
    return add(name, text, name.text());
  }

  /// Parses a definition from `source`. Errors contain the name of the source.
  std::optional<Error> add(const TypeName& name, std::string_view text, const std::string& source) {
    auto parsed = msg::parse(text, name);
    if (!parsed) return error_of(parsed.error().front(), source);
    const auto [known, is_new] = definitions_.try_emplace(name, Known{*std::move(parsed), source});
    if (!is_new) return Error{Errc::malformed, name.text() + " is defined twice"};
    return {};
  }

  /// Parses the definition of a service, and adds its messages.
  std::optional<Error> add_service(const TypeName& service, std::string_view text,
                                   const std::string& source) {
    const auto parsed = msg::parse_service(text, service);
    if (!parsed) return error_of(parsed.error().front(), source);
    for (const Definition& message : *parsed) definitions_.try_emplace(message.type, Known{message, source});
    return {};
  }

  static Error error_of(const msg::Problem& first, const std::string& source) {
    const std::string column = first.column == 0 ? "" : std::to_string(first.column) + ":";
    return {Errc::malformed, source + ":" + std::to_string(first.line) + ":" + column + " " +
                                 (first.member.empty() ? "" : first.member + ": ") + first.text};
  }

  /// Returns the first mistake in the layout rules of `known`. REQUIRES: the definitions of all messages that
  /// it nests are known.
  std::optional<Error> check_layouts_of(const Known& known) const {
    const auto wrong = msg::check_layouts(known.definition, [this](const TypeName& nested) {
      const auto found = definitions_.find(nested);
      return found == definitions_.end() ? nullptr : &found->second.definition;
    });
    return wrong.empty() ? std::nullopt : std::optional(error_of(wrong.front(), known.source));
  }

  /// Makes a member that refers to the field.
  static Member member_of(const msg::Field& field) {
    Member m{.name = field.name, .kind = static_cast<Kind>(field.type.kind)};
    if (field.type.is_sequence) m.shape = Shape::sequence;
    if (field.type.array_size != 0) {
      m.shape = Shape::array;
      m.count = field.type.array_size;
    }
    m.bound = field.type.bound;
    m.string_bound = field.type.string_bound;
    if (field.unit.size() <= unit_bytes_max && is_printable(field.unit)) m.unit = field.unit;
    return m;
  }

  std::optional<msg::SearchPath> search_path_;
  std::map<TypeName, Known> definitions_;
  std::map<TypeName, Made> types_;
  std::vector<TypeName> chain_;  // types that are being made; each type nests the next type in the list
};

Result<TypeName> name_of_message(std::string_view text) {
  if (auto name = type_name(text)) return *std::move(name);
  return fail(Errc::invalid_argument,
              "the name of a message is expected, as in sensor_msgs/PointCloud2, not '" +
                  (is_printable(text) ? std::string(text) : "something unprintable") + "'");
}

Result<DynamicType> made(MsgReader& reader, const TypeName& root, const DynamicType::Limits& limits) {
  const Result<const StructType*> type = reader.type_of(root);
  if (!type) return tl::unexpected(type.error());
  return DynamicType::parse(describe(**type), limits).map_error([&](Error error) {
    return Error{error.code, root.text() + ": " + error.message};
  });
}

}  // namespace

Result<std::string> to_msg(const DynamicType& type) { return MsgWriter().write(type.type()); }

Result<DynamicType> from_msg(std::string_view name, std::string_view text,
                             const DynamicType::Limits& limits) {
  const Result<TypeName> root = name_of_message(name);
  if (!root) return tl::unexpected(root.error());
  MsgReader reader;
  if (auto wrong = reader.read(*root, text)) return tl::unexpected(*std::move(wrong));
  return made(reader, *root, limits);
}

Result<DynamicType> find_msg(std::string_view name, std::span<const std::filesystem::path> roots,
                             const DynamicType::Limits& limits) {
  const Result<TypeName> root = name_of_message(name);
  if (!root) return tl::unexpected(root.error());
  MsgReader reader(msg::SearchPath({roots.begin(), roots.end()}));
  return made(reader, *root, limits);
}

Result<DynamicType> from_msg_file(const std::filesystem::path& file,
                                  std::span<const std::filesystem::path> roots,
                                  const DynamicType::Limits& limits) {
  std::error_code error;
  const std::filesystem::path whole = std::filesystem::absolute(file, error).lexically_normal();
  const std::filesystem::path folder = whole.parent_path();
  const std::filesystem::path package = folder.parent_path();
  const auto name = type_name(package.filename().string() + "/" + whole.stem().string());
  if (folder.filename() != "msg" || whole.extension() != ".msg" || !name) {
    return fail(Errc::invalid_argument,
                "the path of a message is expected, PACKAGE/msg/NAME.msg, not '" + file.string() + "'");
  }
  if (!std::filesystem::is_regular_file(whole, error))
    return fail(Errc::unavailable, "there is no file " + whole.string());
  std::vector<std::filesystem::path> all{package.parent_path()};
  all.insert(all.end(), roots.begin(), roots.end());
  MsgReader reader(msg::SearchPath(std::move(all)));
  return made(reader, *name, limits);
}

}  // namespace sft
