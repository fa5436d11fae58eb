#include "from_msg/parse.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "from_msg/lines.h"
#include "from_msg/literal.h"
#include "from_msg/names.h"
#include "from_msg/type.h"
#include "from_msg/unit.h"
#include "from_msg/utf8.h"
#include "layout/rule.h"

namespace sft::msg {
namespace {

/// The unparsed parts of "int32 x 5" or "int32 X=5".
struct Statement {
  std::string_view type;
  std::string_view name;
  std::string_view value;
  bool is_constant;
};

Statement cut(std::string_view code) {
  const std::size_t type_end = std::min(code.find(' '), code.size());
  const std::string_view rest = trimmed(code.substr(type_end));
  const std::size_t name_end = std::min(rest.find_first_of(" ="), rest.size());
  std::string_view value = trimmed(rest.substr(name_end));
  const bool is_constant = value.starts_with('=');
  if (is_constant) value = trimmed(value.substr(1));
  return {code.substr(0, type_end), rest.substr(0, name_end), value, is_constant};
}

bool has_control_characters(std::string_view code) {
  return std::ranges::any_of(code, [](unsigned char c) { return c < 0x20 || c == 0x7F; });
}

bool is_separator(std::string_view code) {
  return code.starts_with("---") && code.find_first_not_of('-') == code.npos;
}

class Parser {
 public:
  Parser(const TypeName& name, std::uint32_t lines_before)
      : lines_before_(lines_before), line_(lines_before + 1) {
    definition_.type = name;
  }

  tl::expected<Definition, std::vector<Problem>> run(std::string_view text) {
    check_name();
    if (check_text(text)) read(with_plain_spaces(text));
    if (layout_) refuse_layout(*layout_, 0, "", "no field follows that the layout could belong to");
    std::ranges::stable_sort(problems_, {}, &Problem::line);
    if (problems_.size() > Limits::problems)
      problems_.erase(problems_.begin() + Limits::problems, problems_.end());
    if (!problems_.empty()) return tl::unexpected(std::move(problems_));
    for (std::size_t i = 0; i < field_comments_.size(); ++i) {
      const std::string_view unit = unit_in(field_comments_[i]);
      const bool is_of_one_line = unit.find('\n') == unit.npos;
      if (is_of_one_line) definition_.fields[i].unit = unit;
    }
    if (definition_.fields.empty()) add_member_of_empty_message();
    return std::move(definition_);
  }

 private:
  /// Adds the member that ROS 2 adds to a message without fields, so that ROS 2 and SFT have the same byte
  /// on the wire.
  void add_member_of_empty_message() {
    Type type;
    type.kind = SFT_UINT8;
    definition_.fields.push_back({type, "structure_needs_at_least_one_member", {}, {}, line_});
  }

  void check_name() {
    const TypeName& type = definition_.type;
    if (!is_package_name(type.package)) {
      refuse("",
             "{} is not a package name: expected a lower-case letter, then lower-case letters, digits and "
             "single underscores, as in my_msgs",
             shown(type.package));
    }
    if (!is_message_name(type.name)) {
      refuse("",
             "{} is not a message name: expected a capital letter, then letters and digits, as in "
             "PointCloud2",
             shown(type.name));
    }
  }

  /// Returns false if the text cannot be parsed at all.
  bool check_text(std::string_view text) {
    if (text.size() > Limits::bytes) {
      refuse("", "{} bytes: expected at most {}: put parts into messages of their own", text.size(),
             Limits::bytes);
      return false;
    }
    const std::size_t invalid = find_invalid_utf8(text);
    if (invalid == text.npos) return true;
    const std::string before = with_plain_spaces(text.substr(0, invalid));
    line_ = lines_before_ + static_cast<std::uint32_t>(1 + std::ranges::count(before, '\n'));
    refuse("", "this is not UTF-8: convert the file");
    return false;
  }

  void read(const std::string& text) {
    Lines lines(text, lines_before_);
    bool is_head = true;  // true at the top of the file, where a comment belongs to the message
    while (const auto line = lines.next()) {
      line_ = line->number;
      is_head = is_head && line->has_comment && line->code.empty() && !line->is_indented;
      if (!is_head) {
        read_line(*line);
      } else if (const auto layout = layout_in(*line)) {
        refuse_layout(
            *layout, 0, "",
            "the comment at the top belongs to the message, and a layout to a field: write an empty "
            "line above it, or write it behind the field");
      }
      if (problems_.size() >= Limits::problems) return;
      if (definition_.fields.size() + definition_.constants.size() <= Limits::members) continue;
      return refuse("", "too many fields and constants: expected at most {}", Limits::members);
    }
  }

  /// Reads a line. A comment belongs to the definition in its line, or otherwise to the next definition. An
  /// indented comment in a line of its own belongs to the previous definition.
  void read_line(const Line& line) {
    auto layout = layout_in(line);
    if (line.has_comment && line.code.empty() && line.is_indented) {
      if (previous_field_) append_line(field_comments_[*previous_field_], line.comment);
      if (!layout) return;
      if (!previous_field_) return refuse_layout(*layout, 0, "", "no field stands before this layout");
      return set_layout(definition_.fields[*previous_field_], *std::move(layout));
    }
    if (line.has_comment) append_line(comment_, line.comment);
    if (layout && layout_) refuse_layout(*layout, 0, "", "a field has one layout");
    if (layout && !layout_) layout_ = std::move(layout);
    if (line.code.empty()) return;
    previous_field_.reset();
    read_statement(line.code);
    comment_.clear();
    layout_.reset();
  }

  void read_statement(std::string_view code) {
    const Statement statement = cut(code);
    if (has_control_characters(code)) {
      return refuse("", "control characters are not supported here: write them as escapes in strings");
    }
    if (is_separator(code)) {
      return refuse("",
                    "'---' separates the two parts of a service: it stands once in a .srv file, in a line "
                    "with nothing else");
    }
    if (statement.name.empty()) {
      return refuse("",
                    "{} is not a definition: expected 'type name', 'type name default' or 'type NAME=value'",
                    shown(code));
    }
    const auto type = parse_type(statement.type, definition_.type.package);
    if (!type) return refuse(statement.name, "{}", type.error());
    statement.is_constant ? read_constant(*type, statement) : read_field(*type, statement);
  }

  void read_constant(const Type& type, const Statement& statement) {
    if (!is_constant_name(statement.name)) {
      return refuse(
          "",
          "{} is not the name of a constant: expected a capital letter, then capital letters, digits "
          "and single underscores, as in MAX_SPEED; a default is written without '='",
          shown(statement.name));
    }
    if (!type.is_single() || type.kind == SFT_STRUCTURE || type.string_bound != 0) {
      return refuse(statement.name, "{} cannot be the type of a constant: use a primitive type or string",
                    shown(statement.type));
    }
    auto values = parse_values(type, statement.value);
    if (!values) return refuse(statement.name, "{}", values.error());
    if (!is_new(statement.name)) return;
    if (layout_) refuse_layout(*layout_, 0, statement.name, "a layout belongs to a field, not to a constant");
    definition_.constants.push_back({type, std::string(statement.name), std::move(values->front()), line_});
  }

  void read_field(const Type& type, const Statement& statement) {
    if (!is_field_name(statement.name)) {
      return refuse("",
                    "{} is not the name of a field: expected a lower-case letter, then lower-case letters, "
                    "digits and single underscores, as in max_speed; a constant is written NAME=value",
                    shown(statement.name));
    }
    Field field{type, std::string(statement.name), {}, {}, line_};
    if (!statement.value.empty()) {
      auto initial = parse_values(type, statement.value);
      if (!initial) return refuse(statement.name, "{}", initial.error());
      field.initial = *std::move(initial);
    }
    if (!is_new(statement.name)) return;
    previous_field_ = definition_.fields.size();
    definition_.fields.push_back(std::move(field));
    field_comments_.push_back(comment_);
    if (layout_) set_layout(definition_.fields.back(), *std::move(layout_));
  }

  bool is_new(std::string_view name) {
    const auto [first, inserted] = lines_of_names_.try_emplace(std::string(name), line_);
    if (!inserted) refuse(name, "there is one already, in line {}: rename one of them", first->second);
    return inserted;
  }

  /// Returns the layout in the comment of a line. The layout extends to the end of the line.
  static std::optional<Layout> layout_in(const Line& line) {
    const std::size_t at = line.comment.find(layout::annotation);
    if (at == line.comment.npos) return {};
    const std::size_t behind = at + layout::annotation.size();
    const std::size_t begin = std::min(line.comment.find_first_not_of(' ', behind), line.comment.size());
    return Layout{std::string(trimmed(line.comment.substr(begin))), line.number,
                  line.comment_column + static_cast<std::uint32_t>(begin)};
  }

  void set_layout(Field& field, Layout layout) {
    if (!field.layout.text.empty()) return refuse_layout(layout, 0, field.name, "a field has one layout");
    if (const auto rule = layout::read_rule(layout.text); !rule)
      return refuse_layout(layout, rule.error().at, field.name, rule.error().text);
    field.layout = std::move(layout);
  }

  void refuse_layout(const Layout& layout, std::size_t at, std::string_view member, std::string text) {
    problems_.push_back(
        {layout.line, std::string(member), std::move(text), layout.column + static_cast<std::uint32_t>(at)});
  }

  static void append_line(std::string& comment, std::string_view line) {
    comment += line;
    comment += '\n';
  }

  template <class... Args>
  void refuse(std::string_view member, fmt::format_string<Args...> format, Args&&... args) {
    if (!is_field_name(member) && !is_constant_name(member)) member = "";
    problems_.push_back({line_, std::string(member), fmt::format(format, std::forward<Args>(args)...)});
  }

  const std::uint32_t lines_before_;
  Definition definition_;
  std::vector<Problem> problems_;
  std::uint32_t line_;
  std::string comment_;                      // the comment of the next definition
  std::optional<Layout> layout_;             // the layout of the next field
  std::vector<std::string> field_comments_;  // one comment per field
  // The field of the previous definition; empty if the previous definition is a constant.
  std::optional<std::size_t> previous_field_;
  std::unordered_map<std::string, std::uint32_t> lines_of_names_;
};

}  // namespace

tl::expected<Definition, std::vector<Problem>> parse(std::string_view text, const TypeName& name,
                                                     std::uint32_t lines_before) {
  return Parser(name, lines_before).run(text);
}

}  // namespace sft::msg
