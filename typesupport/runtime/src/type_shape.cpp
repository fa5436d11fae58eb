#include "sft/detail/type_shape.h"

#include <algorithm>
#include <array>
#include <set>
#include <string_view>

#include "sft/detail/type_table.h"

namespace sft::detail {

namespace {

std::string name_of(Kind kind) {
  static constexpr std::array names{"boolean", "octet",  "char",  "int8",   "uint8", "int16",  "uint16",
                                    "int32",   "uint32", "int64", "uint64", "float", "double", "string"};
  return names[static_cast<std::size_t>(kind)];
}

std::string element_type(const Member& m) {
  if (m.kind == Kind::structure) return std::string(m.type->name);
  if (m.enumeration != nullptr) return std::string(m.enumeration->name);
  const bool is_bounded = m.kind == Kind::string && m.string_bound != 0;
  return name_of(m.kind) + (is_bounded ? "<" + std::to_string(m.string_bound) + ">" : "");
}

std::string in_collection(const Member& m, const std::string& element) {
  if (m.shape == Shape::single) return element;
  if (m.shape == Shape::array) return element + "[" + std::to_string(m.count) + "]";
  return "sequence<" + element + (m.bound == 0 ? "" : ", " + std::to_string(m.bound)) + ">";
}

/// Returns the text in double quotes.
std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

class ShapeWriter {
 public:
  void write(const StructType& type) {
    if (!written_.insert(&type).second) return;
    for (const Member& m : type.members) {
      if (m.type != nullptr) write(*m.type);
      if (m.enumeration != nullptr) write(*m.enumeration, m.kind);
    }
    begin("struct", type.name);
    for (const Member& m : type.members) write(m);
    out_ += "};\n";
  }

  std::string take() { return std::move(out_); }

 private:
  void begin(const char* what, std::string_view name) {
    if (!out_.empty()) out_ += '\n';
    out_ += what;
    out_ += ' ';
    out_ += name;
    out_ += " {\n";
  }

  void write(const Member& m) {
    out_ += "  ";
    if (m.key) out_ += "@key ";
    if (!m.unit.empty()) out_ += "@unit(" + quoted(m.unit) + ") ";
    if (!m.layout.empty()) out_ += "@sft_layout(" + quoted(m.layout) + ") ";
    const bool is_array = m.shape == Shape::array;
    out_ += (is_array ? element_type(m) : format_type(m)) + " " + std::string(m.name);
    if (is_array) out_ += "[" + std::to_string(m.count) + "]";
    out_ += ";\n";
  }

  void write(const EnumType& type, Kind kind) {
    if (!written_.insert(&type).second) return;
    out_ += out_.empty() ? "" : "\n";
    out_ += "@bit_bound(" + std::to_string(8 * size_of(kind)) + ") ";
    out_ += std::string(type.is_bitmask ? "bitmask " : "enum ") + std::string(type.name) + " {\n";
    for (const Enumerator& e : type.enumerators) {
      out_ += "  " + std::string(e.name) + " = " + std::to_string(e.value) + ",\n";
    }
    out_ += "};\n";
  }

  std::set<const void*> written_;
  std::string out_;
};

std::string differ(const std::string& here, const std::string& there) {
  return here + " here, " + there + " there";
}

std::string_view name_of(const Member& m) { return m.name; }
std::string_view name_of(const Enumerator& e) { return e.name; }

/// Compares the names of members or enumerators in their order. Returns the first difference, or nothing.
template <class Named>
std::string name_difference(std::span<const Named> here, std::span<const Named> there,
                            const std::string& noun) {
  const auto quoted_name = [](const Named& n) { return "'" + std::string(name_of(n)) + "'"; };
  const auto has = [](std::span<const Named> all, const Named& n) {
    return std::any_of(all.begin(), all.end(), [&](const Named& a) { return name_of(a) == name_of(n); });
  };
  const auto more = [&](const Named& n, const char* where) {
    return "one more " + noun + " " + quoted_name(n) + " " + where;
  };
  for (std::size_t i = 0; i < std::max(here.size(), there.size()); ++i) {
    if (i == here.size()) return more(there[i], "there");
    if (i == there.size()) return more(here[i], "here");
    if (name_of(here[i]) == name_of(there[i])) continue;
    if (!has(here, there[i]) && has(there, here[i])) return more(there[i], "there");
    if (!has(there, here[i]) && has(here, there[i])) return more(here[i], "here");
    return noun + " " + std::to_string(i + 1) + " is " + differ(quoted_name(here[i]), quoted_name(there[i]));
  }
  return {};
}

std::string difference(const EnumType& here, const EnumType& there) {
  if (here.is_bitmask != there.is_bitmask) {
    return differ(here.is_bitmask ? "a bitmask" : "an enumeration",
                  there.is_bitmask ? "a bitmask" : "an enumeration");
  }
  const std::string noun = here.is_bitmask ? "flag" : "enumerator";
  std::string names = name_difference(here.enumerators, there.enumerators, noun);
  if (!names.empty()) return names;
  for (std::size_t i = 0; i < here.enumerators.size(); ++i) {
    const Enumerator& a = here.enumerators[i];
    const Enumerator& b = there.enumerators[i];
    if (a.value != b.value) {
      return noun + " '" + std::string(a.name) + "' is " +
             differ(std::to_string(a.value), std::to_string(b.value));
    }
  }
  return {};
}

/// Returns the text of format_type() without the names of structs and enumerations. These are compared by
/// their members.
std::string outline(const Member& m) {
  const bool has_structure = m.kind == Kind::structure || m.enumeration != nullptr;
  return in_collection(m, has_structure ? "" : element_type(m));
}

class Comparison {
 public:
  std::string structs(const StructType& here, const StructType& there, const std::string& prefix) const {
    // Differences inside members are searched for first, but only in the members before the first member
    // whose name differs.
    for (std::size_t i = 0; i < std::min(here.members.size(), there.members.size()); ++i) {
      if (here.members[i].name != there.members[i].name) break;
      std::string found = members(here.members[i], there.members[i], prefix);
      if (!found.empty()) return found;
    }
    std::string names = name_difference(here.members, there.members, "member");
    if (names.empty() || prefix.empty()) return names;
    return prefix.substr(0, prefix.size() - 1) + ": " + names;
  }

 private:
  std::string members(const Member& here, const Member& there, const std::string& prefix) const {
    const std::string path = prefix + std::string(here.name);
    const auto both = [&](const std::string& a, const std::string& b) { return path + ": " + differ(a, b); };
    const bool alike =
        here.kind == there.kind && (here.enumeration == nullptr) == (there.enumeration == nullptr);
    if (!alike || outline(here) != outline(there)) return both(full(here), full(there));
    if (here.key != there.key) return both(here.key ? "a key" : "no key", there.key ? "a key" : "no key");
    if (here.enumeration != nullptr) {
      const std::string found = difference(*here.enumeration, *there.enumeration);
      return found.empty() ? "" : path + ": " + found;
    }
    if (here.type == nullptr) return {};
    return structs(*here.type, *there.type, path + (is_collection(here) ? "[]." : "."));
  }

  /// Returns the type of a member. For an enumeration it includes the integer, which may be the difference.
  static std::string full(const Member& m) {
    return format_type(m) + (m.enumeration == nullptr ? "" : " (" + name_of(m.kind) + ")");
  }
};

}  // namespace

std::string format_type(const Member& member) { return in_collection(member, element_type(member)); }

std::string format_shape(const StructType& type) {
  ShapeWriter writer;
  writer.write(type);
  return writer.take();
}

std::string first_difference(const StructType& here, const StructType& there) {
  return Comparison().structs(here, there, "");
}

}  // namespace sft::detail
