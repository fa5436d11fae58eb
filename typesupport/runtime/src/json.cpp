#include "sft/json.h"
#include "round_to_nearest.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

namespace sft {

using namespace detail;

namespace {

using OrderedJson = nlohmann::ordered_json;

std::string base64(std::span<const std::byte> bytes) {
  static constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (; !bytes.empty(); bytes = bytes.subspan(std::min<std::size_t>(bytes.size(), 3))) {
    std::uint32_t group = 0;
    for (std::size_t i = 0; i < 3; ++i)
      group = group << 8 | (i < bytes.size() ? std::to_integer<std::uint32_t>(bytes[i]) : 0);
    for (std::size_t i = 0; i < 4; ++i) out += i > bytes.size() ? '=' : digits[group >> (18 - 6 * i) & 0x3f];
  }
  return out;
}

/// Returns the double with the shortest decimal text that identifies the float.
double shortest(float value) {
  std::array<char, 32> digits{};
  const auto written = std::to_chars(digits.begin(), digits.end(), value);
  double result = value;
  std::from_chars(digits.begin(), written.ptr, result);
  return result;
}

OrderedJson json_of(double value) {
  if (std::isnan(value)) return "NaN";
  if (std::isinf(value)) return value < 0 ? "-Infinity" : "Infinity";
  return value;
}
OrderedJson json_of(float value) {
  return std::isfinite(value) ? OrderedJson(shortest(value)) : json_of(double{value});
}
OrderedJson json_of(char value) { return std::string(1, value); }
OrderedJson json_of(std::string_view value) { return value; }
template <std::integral I>
OrderedJson json_of(I value) {
  return value;
}

class JsonWriter {
 public:
  explicit JsonWriter(const JsonOptions& options) : options_(options) {}

  Result<std::string> write(const DynamicView& view) {
    if (view.is_absent()) return fail(Errc::unavailable, "the field was not sent in this sample");
    const OrderedJson json = value(view);
    if (failure_) return tl::unexpected(*std::move(failure_));
    return json.dump(options_.indent, ' ', false, OrderedJson::error_handler_t::replace);
  }

 private:
  OrderedJson value(const DynamicView& view) {
    if (view.error() != nullptr) return failed(*view.error());
    if (view.is_struct()) return structure(view);
    if (view.is_collection()) return collection(view);
    return scalar(view);
  }

  OrderedJson structure(const DynamicView& view) {
    OrderedJson object = OrderedJson::object();
    for (const DynamicView& m : view.members()) {
      if (m.is_absent()) continue;
      std::string name(m.name());
      count(name.size() + 4);
      if (m.has_only_size()) {
        name += ".size";
        const Result<std::size_t> size = m.size();
        object[name] = size ? OrderedJson(*size) : failed(size.error());
      } else {
        object[name] = value(m);
      }
      if (failure_) break;
    }
    return object;
  }

  OrderedJson collection(const DynamicView& view) {
    const bool is_bytes = view.kind() == Kind::octet || view.kind() == Kind::uint8;
    if (is_bytes && view.member()->enumeration == nullptr && options_.bytes_as_base64) {
      const auto bytes = view.as<std::span<const std::byte>>();
      if (!bytes) return failed(bytes.error());
      return count(bytes->size() * 4 / 3) ? OrderedJson(base64(*bytes)) : OrderedJson();
    }
    OrderedJson array = OrderedJson::array();
    const Result<std::size_t> size = view.size();
    if (!size) return failed(size.error());
    for (const DynamicView& element : view.elements()) {
      if (array.size() == options_.elements_max) {
        const std::size_t more = *size - std::min(*size, options_.elements_max);
        array.push_back("... " + std::to_string(more) + " more");
        break;
      }
      count(2);
      array.push_back(value(element));
      if (failure_) break;
    }
    return array;
  }

  OrderedJson scalar(const DynamicView& view) {
    const Result<DynamicView::Scalar> value = view.scalar();
    if (!value) return failed(value.error());
    const auto* text = std::get_if<std::string_view>(&*value);
    if (!count(text == nullptr ? 4 : text->size() + 2)) return {};
    if (view.member()->enumeration != nullptr) {
      if (auto symbol = view.enumerator()) return *std::move(symbol);
    }
    return std::visit([](const auto& v) { return json_of(v); }, *value);
  }

  /// Adds to the approximate size of the output before memory is allocated for it. Returns false if that
  /// exceeds the limit.
  bool count(std::size_t bytes) {
    bytes_ += bytes;
    if (bytes_ <= options_.output_bytes_max) return true;
    failed({Errc::limit_exceeded, "the text would have more than " +
                                      std::to_string(options_.output_bytes_max) +
                                      " bytes; lower the limit of elements"});
    return false;
  }

  OrderedJson failed(const Error& error) {
    if (!failure_) failure_ = error;
    return {};
  }

  const JsonOptions& options_;
  std::size_t bytes_ = 0;
  std::optional<Error> failure_;
};

}  // namespace

Result<std::string> to_json(const DynamicView& view, const JsonOptions& options) {
  const RoundToNearest rounding;
  return JsonWriter(options).write(view);
}

}  // namespace sft
