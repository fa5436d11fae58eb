#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cmath>
#include <concepts>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <utility>

#include "round_to_nearest.h"
#include "sft/detail/sample_format.h"
#include "sft/detail/text.h"
#include "sft/detail/type_table.h"
#include "sft/detail/walk.h"
#include "sft/json.h"

namespace sft {

using namespace detail;

namespace {

using Json = nlohmann::json;

static_assert(std::endian::native == std::endian::little, "primitives are written as they are");

/// Decodes base64 (RFC 4648, padded); returns nothing if the text is not base64.
std::optional<std::vector<std::byte>> from_base64(std::string_view text) {
  static constexpr std::array<std::uint8_t, 256> values = [] {
    constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::array<std::uint8_t, 256> of{};
    of.fill(0xff);
    for (std::size_t i = 0; i < digits.size(); ++i)
      of[static_cast<std::uint8_t>(digits[i])] = static_cast<std::uint8_t>(i);
    return of;
  }();
  if (text.size() % 4 != 0) return {};
  std::vector<std::byte> bytes;
  bytes.reserve(text.size() / 4 * 3);
  while (!text.empty()) {
    const bool is_last = text.size() == 4;
    const std::size_t padding = !is_last ? 0 : text.ends_with("==") ? 2 : text.ends_with('=') ? 1 : 0;
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::uint8_t value = i < 4 - padding ? values[static_cast<std::uint8_t>(text[i])] : 0;
      if (value == 0xff) return {};
      group = group << 6 | value;
    }
    for (std::size_t i = 0; i < 3 - padding; ++i)
      bytes.push_back(static_cast<std::byte>(group >> (16 - 8 * i)));
    text.remove_prefix(4);
  }
  return bytes;
}

/// Returns a short description of the JSON value, for error messages.
std::string shown(const Json& json) {
  constexpr std::size_t most = 40;
  if (json.is_object()) return "an object";
  if (json.is_array()) return "an array";
  std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace);
  if (text.size() > most) text = text.substr(0, most) + "...";
  return text;
}

/// Writes the body of a whole message, member by member. Stops at the first error.
class CdrWriter {
 public:
  explicit CdrWriter(const FromJsonOptions& options) : options_(options), out_(encapsulation_bytes) {
    std::memcpy(out_.data(), encapsulation_cdr_le.data(), encapsulation_bytes);
  }

  Result<std::vector<std::byte>> write(const StructType& type, const Json& json) {
    structure(type, &json);
    if (wrong_) return tl::unexpected(*std::move(wrong_));
    return std::move(out_);
  }

 private:
  /// Appends a member's name or an element's index to the path for error messages, and removes it in the
  /// destructor.
  class Step {
   public:
    Step(std::string& path, std::string_view name) : path_(path), before_(path.size()) {
      if (!path.empty() && !name.starts_with('[')) path += '.';
      path += name;
    }
    ~Step() { path_.resize(before_); }
    Step(const Step&) = delete;
    Step& operator=(const Step&) = delete;

   private:
    std::string& path_;
    const std::size_t before_;
  };

  /// Writes a struct. `json` is null if the struct is left out: all members are then zero or empty.
  void structure(const StructType& type, const Json* json) {
    if (json != nullptr && !json->is_object()) {
      if (const auto meant = meant_by_a_word(type, *json)) return structure(type, &*meant);
      return expected(*json, "an object with the members of " + std::string(type.name) + word_for(type));
    }
    std::size_t known = 0;
    for (const Member& m : type.members) {
      if (wrong_) return;
      const Json* value = nullptr;
      if (json != nullptr) {
        const auto found = json->find(std::string(m.name));
        if (found != json->end()) value = &*found;
      }
      known += value != nullptr ? 1 : 0;
      const Step step(path_, m.name);
      member(m, value);
    }
    if (json == nullptr || wrong_ || known == json->size()) return;
    refuse_the_unknown(type, *json);
  }

  static constexpr std::string_view stamp_name = "builtin_interfaces::msg::Time";
  static constexpr std::string_view header_name = "std_msgs::msg::Header";

  /// Returns the value for the word "now" or "auto", if `json` is such a word and the options allow it.
  std::optional<Json> meant_by_a_word(const StructType& type, const Json& json) const {
    if (!options_.now) return {};
    if (type.name == header_name && json == "auto") return Json{{"stamp", "now"}};
    if (type.name != stamp_name || json != "now") return {};
    const auto since_epoch = options_.now->time_since_epoch();
    const auto seconds = std::chrono::floor<std::chrono::seconds>(since_epoch);
    return Json{{"sec", seconds.count()}, {"nanosec", (since_epoch - seconds).count()}};
  }

  /// Returns the words that are allowed for the type, for an error message.
  const char* word_for(const StructType& type) const {
    if (!options_.now) return "";
    return type.name == stamp_name ? R"(, or "now",)" : type.name == header_name ? R"(, or "auto",)" : "";
  }

  void refuse_the_unknown(const StructType& type, const Json& json) {
    for (const auto& [name, value] : json.items()) {
      const auto is_it = [&](const Member& m) { return m.name == name; };
      if (std::any_of(type.members.begin(), type.members.end(), is_it)) continue;
      const Step step(path_, is_printable(name) ? std::string_view(name) : "?");
      const auto nearest =
          std::min_element(type.members.begin(), type.members.end(), [&](const Member& a, const Member& b) {
            return edit_distance(a.name, name) < edit_distance(b.name, name);
          });
      return fail(Errc::unknown_field, "'" + path_ + "' is no member of " + std::string(type.name) +
                                           "; did you mean '" + std::string(nearest->name) + "'?");
    }
  }

  void member(const Member& m, const Json* json) {
    if (m.shape == Shape::single) return element(m, json);
    if (json == nullptr) return left_out(m);
    const bool is_bytes = (m.kind == Kind::octet || m.kind == Kind::uint8) && m.enumeration == nullptr;
    if (is_bytes && json->is_string()) return base64(m, json->get_ref<const std::string&>());
    if (!json->is_array()) return expected(*json, is_bytes ? "an array, or bytes in base64," : "an array");
    if (!begin_elements(m, json->size())) return;
    for (std::size_t i = 0; i < json->size() && !wrong_; ++i) {
      const Step step(path_, "[" + std::to_string(i) + "]");
      element(m, &(*json)[i]);
    }
  }

  void left_out(const Member& m) {
    if (m.shape == Shape::sequence) return put(std::uint32_t{0});
    for (std::uint32_t i = 0; i < m.count && !wrong_; ++i) element(m, nullptr);
  }

  void base64(const Member& m, const std::string& text) {
    const auto bytes = from_base64(text);
    if (!bytes) return fail(Errc::type_mismatch, "'" + path_ + "' is no base64 (RFC 4648, padded)");
    if (!begin_elements(m, bytes->size()) || !room_for(bytes->size())) return;
    out_.insert(out_.end(), bytes->begin(), bytes->end());
  }

  /// Writes the length of a sequence, or checks the length of an array.
  bool begin_elements(const Member& m, std::size_t count) {
    if (m.shape == Shape::array && count != m.count) {
      fail(Errc::type_mismatch, "'" + path_ + "' has " + std::to_string(count) + " elements; " +
                                    std::to_string(m.count) + " were expected");
    } else if (m.shape == Shape::sequence && m.bound != 0 && count > m.bound) {
      fail(Errc::limit_exceeded, "'" + path_ + "' has " + std::to_string(count) + " elements; its bound is " +
                                     std::to_string(m.bound));
    } else if (m.shape == Shape::sequence) {
      put(static_cast<std::uint32_t>(count));
    }
    return !wrong_;
  }

  void element(const Member& m, const Json* json) {
    switch (m.kind) {
      case Kind::boolean:
        return boolean(json);
      case Kind::octet:
      case Kind::uint8:
        return integer<std::uint8_t>(m, json);
      case Kind::character:
        return character(json);
      case Kind::int8:
        return integer<std::int8_t>(m, json);
      case Kind::int16:
        return integer<std::int16_t>(m, json);
      case Kind::uint16:
        return integer<std::uint16_t>(m, json);
      case Kind::int32:
        return integer<std::int32_t>(m, json);
      case Kind::uint32:
        return integer<std::uint32_t>(m, json);
      case Kind::int64:
        return integer<std::int64_t>(m, json);
      case Kind::uint64:
        return integer<std::uint64_t>(m, json);
      case Kind::float32:
        return real<float>(json);
      case Kind::float64:
        return real<double>(json);
      case Kind::string:
        return string(m, json);
      case Kind::structure:
        return structure(*m.type, json);
    }
  }

  void boolean(const Json* json) {
    if (json == nullptr) return put(std::uint8_t{0});
    if (!json->is_boolean()) return expected(*json, "true or false");
    put(static_cast<std::uint8_t>(json->get<bool>() ? 1 : 0));
  }

  void character(const Json* json) {
    if (json == nullptr) return put('\0');
    const auto* text = json->get_ptr<const std::string*>();
    if (text == nullptr || text->size() != 1) return expected(*json, "a string of one ASCII character");
    put(text->front());
  }

  template <std::integral I>
  void integer(const Member& m, const Json* json) {
    if (json == nullptr) return put(I{});
    if (json->is_number_unsigned() && std::in_range<I>(json->get<std::uint64_t>()))
      return put(static_cast<I>(json->get<std::uint64_t>()));
    if (json->is_number_integer() && !json->is_number_unsigned() &&
        std::in_range<I>(json->get<std::int64_t>()))
      return put(static_cast<I>(json->get<std::int64_t>()));
    if (m.enumeration != nullptr && json->is_string()) {
      if (const auto value = value_of(*m.enumeration, json->get_ref<const std::string&>()))
        return put(static_cast<I>(*value));
    }
    const std::string range = "an integer from " + std::to_string(std::numeric_limits<I>::min()) + " to " +
                              std::to_string(std::numeric_limits<I>::max());
    expected(*json, m.enumeration == nullptr ? range : names_of(*m.enumeration) + " or " + range);
  }

  /// Returns the value of names like "GREEN", or "READ | WRITE" for a bitmask; nothing if a name is
  /// unknown.
  static std::optional<std::uint64_t> value_of(const EnumType& type, std::string_view text) {
    std::uint64_t value = 0;
    for (;;) {
      const std::size_t end = type.is_bitmask ? text.find(" | ") : text.npos;
      const std::string_view name = text.substr(0, end);
      const auto found = std::find_if(type.enumerators.begin(), type.enumerators.end(),
                                      [&](const Enumerator& e) { return e.name == name; });
      if (found == type.enumerators.end()) return {};
      value |= found->value;
      if (end == text.npos) return value;
      text.remove_prefix(end + 3);
    }
  }

  static std::string names_of(const EnumType& type) {
    constexpr std::size_t most = 8;
    std::string text = type.is_bitmask ? "flags of " : "one of ";
    for (std::size_t i = 0; i < type.enumerators.size() && i < most; ++i)
      text += (i == 0 ? "" : ", ") + std::string(type.enumerators[i].name);
    return text + (type.enumerators.size() > most ? ", ..." : "");
  }

  template <std::floating_point F>
  void real(const Json* json) {
    if (json == nullptr) return put(F{});
    if (json->is_number()) {
      const double value = json->get<double>();
      constexpr double most = std::numeric_limits<F>::max();
      if (std::abs(value) <= most) return put(static_cast<F>(value));
    }
    if (*json == "NaN") return put(std::numeric_limits<F>::quiet_NaN());
    if (*json == "Infinity") return put(std::numeric_limits<F>::infinity());
    if (*json == "-Infinity") return put(-std::numeric_limits<F>::infinity());
    expected(*json, sizeof(F) == sizeof(float)
                        ? R"(a number that a float holds, "NaN", "Infinity" or "-Infinity")"
                        : R"(a number, "NaN", "Infinity" or "-Infinity")");
  }

  void string(const Member& m, const Json* json) {
    static const std::string nothing;
    if (json != nullptr && !json->is_string()) return expected(*json, "a string");
    const std::string& text = json == nullptr ? nothing : json->get_ref<const std::string&>();
    if (m.string_bound != 0 && text.size() > m.string_bound) {
      return fail(Errc::limit_exceeded, "'" + path_ + "' has " + std::to_string(text.size()) +
                                            " characters; its bound is " + std::to_string(m.string_bound));
    }
    if (text.find('\0') != text.npos)
      return fail(Errc::type_mismatch, "'" + path_ + "' has a NUL in it; a string ends at its first one");
    put(static_cast<std::uint32_t>(text.size() + 1));
    if (!room_for(text.size() + 1)) return;
    const auto* first = reinterpret_cast<const std::byte*>(text.c_str());
    out_.insert(out_.end(), first, first + text.size() + 1);
  }

  template <class V>
  void put(V value) {
    const std::size_t at = align_up(out_.size() - encapsulation_bytes, sizeof value) + encapsulation_bytes;
    if (!room_for(at + sizeof value - out_.size())) return;
    out_.resize(at + sizeof value);
    std::memcpy(out_.data() + at, &value, sizeof value);
  }

  bool room_for(std::size_t bytes) {
    if (wrong_) return false;
    if (out_.size() - encapsulation_bytes + bytes <= options_.bytes_max) return true;
    fail(Errc::limit_exceeded, "'" + path_ + "' is where the message has more than " +
                                   std::to_string(options_.bytes_max) + " bytes");
    return false;
  }

  void expected(const Json& json, const std::string& what) {
    const std::string where = path_.empty() ? "the message" : "'" + path_ + "'";
    fail(Errc::type_mismatch, where + " is " + shown(json) + "; " + what + " was expected");
  }

  void fail(Errc code, std::string message) {
    if (!wrong_) wrong_ = Error{code, std::move(message)};
  }

  const FromJsonOptions& options_;
  std::vector<std::byte> out_;
  std::string path_;
  std::optional<Error> wrong_;
};

}  // namespace

Result<std::vector<std::byte>> cdr_from_json(const StructType& type, std::string_view json,
                                             const FromJsonOptions& options) {
  const RoundToNearest rounding;
  try {
    return CdrWriter(options).write(type, Json::parse(json));
  } catch (const Json::parse_error& error) {
    return fail(Errc::malformed, "the text is no JSON: the error is at byte " + std::to_string(error.byte));
  } catch (const Json::exception& error) {
    return fail(Errc::malformed, std::string("this is no JSON: ") + error.what());
  }
}

}  // namespace sft
