#include "tools/recording/sample_type.h"

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "sft/msg_text.h"

namespace sft::recording {

namespace {

using Member = StructType::Member;

constexpr std::size_t separator_width = 80;

/// Returns the name of the type as .msg files have it for members: "std_msgs/Header".
std::string member_type_name(std::string_view name) {
  std::string text = ros_type_name(name);
  if (const std::size_t at = text.find("/msg/"); at != text.npos) text.erase(at, 4);
  return text;
}

/// The lines of each definition in a text from to_msg(): one line for each member, in order.
using Lines = std::vector<std::string>;

std::map<std::string, Lines> lines_by_type(const std::string& root, const std::string& text) {
  std::map<std::string, Lines> definitions;
  std::string name = root;
  definitions[name];
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size());
    std::string line = text.substr(at, end - at);
    at = end + 1;
    if (line.starts_with("===")) continue;
    if (line.starts_with("MSG: ")) {
      name = line.substr(5);
      definitions[name];
    } else {
      definitions[name].push_back(std::move(line));
    }
  }
  return definitions;
}

/// Writes the definition of a type, without the fields that are not in a mask.
class ProjectedDefinition {
 public:
  explicit ProjectedDefinition(std::map<std::string, Lines> whole) : whole_(std::move(whole)) {}

  /// Returns the name of the type with these leaves, and writes its definition if it is new. `first` is the
  /// first leaf of the type in the mask.
  std::string add(const StructType& type, const FieldMask& mask, std::size_t first) {
    FieldMask own(type.leaves);
    for (std::size_t leaf = 0; leaf < type.leaves; ++leaf) {
      if (mask.contains(first + leaf)) own.insert(leaf);
    }
    const std::string plain = member_type_name(type.name);
    const std::string name = own.is_full() ? plain : plain + "Part" + hex(own.hash());
    const auto place = std::ranges::find(definitions_, name, &Definition::name) - definitions_.begin();
    if (static_cast<std::size_t>(place) < definitions_.size()) return name;
    definitions_.push_back({name, {}});
    std::string text;
    const Lines& lines = whole_[plain];
    std::size_t leaf = first;
    for (std::size_t i = 0; i < type.members.size() && i < lines.size(); ++i) {
      const Member& m = type.members[i];
      const std::size_t count = leaf_count(m);
      if (mask.any_of(leaf, count)) text += line(m, lines[i], mask, leaf, own.is_full()) + "\n";
      leaf += count;
    }
    definitions_[static_cast<std::size_t>(place)].text = std::move(text);
    return name;
  }

  std::string text() const {
    std::string all;
    for (const Definition& definition : definitions_) {
      if (!all.empty() || &definition != &definitions_.front())
        all += std::string(separator_width, '=') + "\nMSG: " + definition.name + "\n";
      all += definition.text;
    }
    return all;
  }

 private:
  struct Definition {
    std::string name, text;
  };

  static std::string hex(std::uint64_t number) {
    constexpr const char* digits = "0123456789abcdef";
    std::string text;
    for (; number != 0; number >>= 4) text.insert(text.begin(), digits[number & 15]);
    return text.empty() ? "0" : text;
  }

  std::string line(const Member& m, const std::string& whole, const FieldMask& mask, std::size_t leaf,
                   bool is_whole) {
    // The layout rule is removed if the type is not whole, because the rule names members that may be
    // missing.
    std::string text = is_whole ? whole : whole.substr(0, whole.find("  #"));
    if (m.kind != Member::Kind::structure) return text;
    const bool is_sequence = m.shape == Member::Shape::sequence;
    const std::size_t inner = leaf + (is_sequence ? 1 : 0);
    if (!mask.any_of(inner, m.type->leaves)) return "uint32 " + std::string(m.name) + "_size";
    return text.replace(0, member_type_name(m.type->name).size(), add(*m.type, mask, inner));
  }

  std::map<std::string, Lines> whole_;
  std::vector<Definition> definitions_;
};

/// Returns true if the parts do not become whole when the fields that belong to them are added.
bool keeps_parts(const TypeSupport& type, const Selection& selection) {
  const Selection closed = type.closed(selection);
  return std::ranges::all_of(selection.parts(),
                             [&](const Selection::Part& part) { return closed.part(part.leaf) != nullptr; });
}

/// Adds all other fields of the message. A field that would make a part whole gets the same part.
Result<Selection> with_rest_of_message(const TypeSupport& type, const Selection& parts_only) {
  std::vector<Selection::Part> parts(parts_only.parts().begin(), parts_only.parts().end());
  const std::size_t named = parts.size();
  for (std::size_t leaf = 0; leaf < type.leaves(); ++leaf) {
    if (parts_only.mask().contains(leaf)) continue;
    for (std::size_t i = 0; i < named; ++i) {
      FieldMask mask(type.leaves());
      mask.insert(parts[i].leaf);
      mask.insert(leaf);
      const Result<Selection> with_leaf = Selection::make(mask, {parts[i]}, {});
      if (!with_leaf || keeps_parts(type, *with_leaf)) continue;
      Selection::Part same = parts[i];
      same.leaf = static_cast<std::uint32_t>(leaf);
      parts.push_back(std::move(same));
      break;
    }
  }
  return Selection::make(type.full(), std::move(parts), parts_only.gate());
}

}  // namespace

std::string ros_type_name(std::string_view name) {
  std::string path(name);
  for (std::size_t at = path.find("::"); at != path.npos; at = path.find("::")) path.replace(at, 2, "/");
  return path;
}

Result<SampleType> sample_type(const DynamicType& type, const FieldMask& mask) {
  const Result<std::string> whole = to_msg(type);
  if (!whole) return tl::unexpected(whole.error());
  std::string name = ros_type_name(type.name());
  if (mask.is_full()) return SampleType{std::move(name), *whole};
  ProjectedDefinition projected(lines_by_type(member_type_name(type.name()), *whole));
  const std::string short_name = projected.add(type.type(), mask, 0);
  name = name.substr(0, name.rfind('/')) + short_name.substr(short_name.find('/'));
  return SampleType{std::move(name), projected.text()};
}

Result<Selection> selection_of(const DynamicType& type, std::string_view text) {
  const TypeSupport& support = type.support();
  if (text.find_first_not_of(' ') == text.npos) return Selection(support.full());
  Result<Selection> selection = support.parse_selection(text);
  if (!selection) return selection;
  if (selection->mask().empty()) {
    selection = Selection::make(support.full(), {}, selection->gate());
  } else if (selection->parts().size() == selection->mask().size()) {
    selection = with_rest_of_message(support, *selection);
  }
  if (selection) selection = support.closed(*selection);
  return selection;
}

}  // namespace sft::recording
