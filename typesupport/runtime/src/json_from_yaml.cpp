#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <locale>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "round_to_nearest.h"
#include "sft/detail/text.h"
#include "sft/detail/type_table.h"
#include "sft/yaml.h"

namespace sft {

using namespace detail;

namespace {

using Json = nlohmann::json;

constexpr std::size_t values_per_byte_max = 64;

std::string place(const YAML::Mark& mark) {
  return "line " + std::to_string(mark.line + 1) + ", column " + std::to_string(mark.column + 1);
}

/// An event handler that ignores all events of a document.
class Nothing final : public YAML::EventHandler {
 public:
  using Mark = YAML::Mark;
  using Style = YAML::EmitterStyle::value;

  void OnDocumentStart(const Mark&) override {}
  void OnDocumentEnd() override {}
  void OnNull(const Mark&, YAML::anchor_t) override {}
  void OnAlias(const Mark&, YAML::anchor_t) override {}
  void OnScalar(const Mark&, const std::string&, YAML::anchor_t, const std::string&) override {}
  void OnSequenceStart(const Mark&, const std::string&, YAML::anchor_t, Style) override {}
  void OnSequenceEnd() override {}
  void OnMapStart(const Mark&, const std::string&, YAML::anchor_t, Style) override {}
  void OnMapEnd() override {}
};

/// Returns true if the text has a second document. Load() ignores further documents. LoadAll() of yaml-cpp
/// 0.7 uses up all memory for a text that begins with a comma.
bool has_more_than_one(const std::string& text) {
  std::istringstream in(text);
  YAML::Parser parser(in);
  Nothing nothing;
  parser.HandleNextDocument(nothing);
  return static_cast<bool>(parser);
}

/// Reads a number by the rules of yaml-cpp, but independently of the program's global locale, which
/// yaml-cpp uses: with a decimal comma, 1.5 would be 15. Returns nothing if the number is not the whole
/// text, or if the type cannot hold it.
template <class Number>
std::optional<Number> number_of(const std::string& text) {
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  in.unsetf(std::ios::dec);  // makes the stream accept hexadecimal (0x) and octal (0) numbers
  if (std::is_unsigned_v<Number> && in.peek() == '-') return {};
  Number value{};
  if (!(in >> std::noskipws >> value) || in.peek() != std::istringstream::traits_type::eof()) return {};
  return value;
}

std::optional<double> real_of(const std::string& text) {
  const bool has_sign = text.starts_with('-') || text.starts_with('+');
  const std::string_view digits = std::string_view(text).substr(has_sign ? 1 : 0);
  if (digits == ".inf" || digits == ".Inf" || digits == ".INF")
    return text.starts_with('-') ? -HUGE_VAL : HUGE_VAL;
  if (text == ".nan" || text == ".NaN" || text == ".NAN") return std::numeric_limits<double>::quiet_NaN();
  return number_of<double>(text);
}

/// Translates YAML to JSON, to the depth of the type and no deeper. A value that does not fit the type
/// becomes a value that cdr_from_json() refuses, with its path in the error.
class JsonMaker {
 public:
  /// Limits the number of values that are made, because aliases may multiply them. A text without aliases
  /// has fewer values than bytes.
  explicit JsonMaker(std::size_t text_bytes) : values_left_(values_per_byte_max * text_bytes) {}

  Result<Json> make(const StructType& type, const YAML::Node& root) {
    Json json = structure(type, root);
    if (wrong_) return tl::unexpected(*std::move(wrong_));
    return json;
  }

 private:
  Json structure(const StructType& type, const YAML::Node& node) {
    if (!node.IsMap()) return other(node);
    Json object = Json::object();
    for (const auto& pair : node) {
      if (!count()) break;
      const std::string name = pair.first.IsScalar() ? pair.first.Scalar() : "?";
      const auto member = std::find_if(type.members.begin(), type.members.end(),
                                       [&](const Member& m) { return m.name == name; });
      Json value = member == type.members.end() ? other(pair.second) : value_of(*member, pair.second);
      if (object.emplace(name, std::move(value)).second || wrong_) continue;
      const std::string shown = is_printable(name) ? "'" + name + "'" : "a name";
      wrong_ = Error{Errc::malformed,
                     shown + " stands twice in one mapping, the second time in " + place(pair.first.Mark())};
    }
    return object;
  }

  Json value_of(const Member& m, const YAML::Node& node) {
    if (m.shape == Shape::single) return element(m, node);
    // The scalar may be base64.
    if (!node.IsSequence()) return node.IsScalar() ? Json(node.Scalar()) : other(node);
    Json array = Json::array();
    for (const YAML::Node& each : node) {
      if (!count()) break;
      array.push_back(element(m, each));
    }
    return array;
  }

  Json element(const Member& m, const YAML::Node& node) {
    if (m.kind == Kind::structure) return structure(*m.type, node);
    return node.IsScalar() ? scalar(m, node) : other(node);
  }

  /// Reads a scalar by the rules of YAML. Quoted scalars, and scalars of text fields, are text.
  static Json scalar(const Member& m, const YAML::Node& node) {
    const bool is_text = node.Tag() == "!" || node.Tag() == "tag:yaml.org,2002:str";
    if (m.kind == Kind::string || m.kind == Kind::character || is_text) return node.Scalar();
    if (bool b = false; m.kind == Kind::boolean && YAML::convert<bool>::decode(node, b)) return b;
    if (const auto i = number_of<std::int64_t>(node.Scalar())) return *i;
    if (const auto u = number_of<std::uint64_t>(node.Scalar())) return *u;
    if (const auto d = real_of(node.Scalar())) {
      if (std::isnan(*d)) return "NaN";
      if (std::isinf(*d)) return *d < 0 ? "-Infinity" : "Infinity";
      return *d;
    }
    return node.Scalar();
  }

  /// Translates a value that the type does not allow at this place.
  static Json other(const YAML::Node& node) {
    if (node.IsMap()) return Json::object();
    if (node.IsSequence()) return Json::array();
    return node.IsScalar() ? Json(node.Scalar()) : Json();
  }

  bool count() {
    if (values_left_ == 0 && !wrong_)
      wrong_ = Error{Errc::limit_exceeded, "aliases multiply the values of the text too often: write it out"};
    values_left_ -= values_left_ == 0 ? 0 : 1;
    return !wrong_;
  }

  std::size_t values_left_;
  std::optional<Error> wrong_;
};

}  // namespace

Result<std::string> json_from_yaml(const StructType& type, std::string_view yaml) {
  if (Json::accept(yaml)) return std::string(yaml);
  const RoundToNearest rounding;
  try {
    const std::string text(yaml);
    const YAML::Node root = YAML::Load(text);
    if (has_more_than_one(text))
      return fail(Errc::malformed,
                  "there is more behind the first document of YAML; one message was expected");
    return JsonMaker(yaml.size()).make(type, root).map([](const Json& json) {
      return json.dump(-1, ' ', false, Json::error_handler_t::replace);
    });
  } catch (const YAML::Exception& error) {
    return fail(Errc::malformed, "this is no YAML in " + place(error.mark) + ": " +
                                     (is_printable(error.msg) ? error.msg : "it cannot be read"));
  }
}

}  // namespace sft
