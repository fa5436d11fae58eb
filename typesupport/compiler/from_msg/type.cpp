#include "from_msg/type.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <limits>

#include "from_msg/names.h"
#include "from_msg/utf8.h"

namespace sft::msg {
namespace {

using Error = tl::unexpected<std::string>;

constexpr std::string_view at_most = "<=";

struct Primitive {
  std::string_view name;
  sft_kind kind;
};

constexpr auto primitives = std::to_array<Primitive>({
    {"bool", SFT_BOOLEAN},
    {"byte", SFT_OCTET},
    {"int8", SFT_INT8},
    {"uint8", SFT_UINT8},
    {"int16", SFT_INT16},
    {"uint16", SFT_UINT16},
    {"int32", SFT_INT32},
    {"uint32", SFT_UINT32},
    {"int64", SFT_INT64},
    {"uint64", SFT_UINT64},
    {"float32", SFT_FLOAT32},
    {"float64", SFT_FLOAT64},
    {"string", SFT_STRING},
    {"char", SFT_UINT8},  // a number in ROS 2, and no character
});

/// Parses a number from 1 to `most`.
std::optional<std::uint32_t> parse_count(std::string_view digits, std::uint32_t most) {
  std::uint32_t count = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), count);
  const bool is_count = error == std::errc() && end == digits.data() + digits.size();
  return is_count && count > 0 && count <= most ? std::optional(count) : std::nullopt;
}

Error no_count(std::string_view digits, std::uint32_t most) {
  return Error(fmt::format("{} is not a size: expected a whole number from 1 to {}", shown(digits), most));
}

/// Removes "[...]" from the end of `text`, and sets the array size or bound of `type`.
tl::expected<void, std::string> parse_brackets(std::string_view& text, Type& type) {
  if (!text.ends_with(']')) return {};
  const std::size_t open = text.rfind('[');
  if (open == text.npos) return Error("']' without a '[': expected T[N], T[] or T[<=N]");
  std::string_view size = text.substr(open + 1, text.size() - open - 2);
  text = text.substr(0, open);
  if (text.ends_with(']')) {
    return Error("arrays have one dimension: put the inner one into a message of its own");
  }
  // The limits are those of the emitted C++: arrays are members of structs, and bounds have 32 bits.
  const bool is_bound = size.starts_with(at_most);
  const std::uint32_t most =
      is_bound ? std::numeric_limits<std::uint32_t>::max() : std::numeric_limits<std::int32_t>::max();
  if (is_bound) size.remove_prefix(at_most.size());
  type.is_sequence = is_bound || size.empty();
  if (size.empty() && !is_bound) return {};
  const auto count = parse_count(size, most);
  if (!count) return no_count(size, most);
  (is_bound ? type.bound : type.array_size) = *count;
  return {};
}

tl::expected<void, std::string> parse_string_bound(std::string_view digits, Type& type) {
  constexpr std::uint32_t most = std::numeric_limits<std::uint32_t>::max();
  const auto bound = parse_count(digits, most);
  if (!bound) return no_count(digits, most);
  type.kind = SFT_STRING;
  type.string_bound = *bound;
  return {};
}

/// Refuses types of ROS that SFT lacks, with an error that says what to use instead.
tl::expected<void, std::string> check_support(std::string_view name) {
  if (name == "wstring" || name.starts_with("wstring<=")) {
    return Error("wide characters are not supported: use string, which holds UTF-8");
  }
  if (name == "time" || name == "duration") {
    return Error(fmt::format("'{}' is a type of ROS 1: use builtin_interfaces/{}", name,
                             name == "time" ? "Time" : "Duration"));
  }
  if (name.find('<') != name.npos) {
    return Error(fmt::format("{} is not a type: a bound is written string<=N, or T[<=N], without spaces",
                             shown(name)));
  }
  return {};
}

/// Parses a name like "Point", "geometry_msgs/Point" or "geometry_msgs/msg/Point".
tl::expected<TypeName, std::string> parse_nested(std::string_view text, std::string_view package) {
  const std::size_t first = text.find('/');
  const std::size_t last = text.rfind('/');
  const bool is_good = first == last || text.substr(first, last - first) == "/msg";
  const TypeName name{std::string(first == text.npos ? package : text.substr(0, first)),
                      std::string(last == text.npos ? text : text.substr(last + 1))};
  if (!is_good || !is_package_name(name.package) || !is_message_name(name.name)) {
    return Error(fmt::format(
        "{} is not a type: expected bool, byte, char, int8 to int64, uint8 to uint64, float32, float64, "
        "string, or a message as Name or package/Name",
        shown(text)));
  }
  return name;
}

tl::expected<void, std::string> parse_element(std::string_view text, std::string_view package, Type& type) {
  const auto primitive = std::ranges::find(primitives, text, &Primitive::name);
  if (primitive != primitives.end()) {
    type.kind = primitive->kind;
    return {};
  }
  constexpr std::string_view bounded = "string<=";
  if (text.starts_with(bounded)) return parse_string_bound(text.substr(bounded.size()), type);
  if (const auto supported = check_support(text); !supported) return supported;
  auto nested = parse_nested(text, package);
  if (!nested) return Error(nested.error());
  type.kind = SFT_STRUCTURE;
  type.nested = *std::move(nested);
  return {};
}

}  // namespace

tl::expected<Type, std::string> parse_type(std::string_view text, std::string_view package) {
  Type type;
  if (const auto brackets = parse_brackets(text, type); !brackets) return Error(brackets.error());
  if (const auto element = parse_element(text, package, type); !element) return Error(element.error());
  return type;
}

std::string_view spelling_of(sft_kind kind) {
  return std::ranges::find(primitives, kind, &Primitive::kind)->name;
}

}  // namespace sft::msg
