#include "sft/yaml.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>

#include "sft/detail/text.h"

namespace sft {

using namespace detail;

namespace {

bool is_word(std::string_view text) {  // true if YAML would not read the text as a string
  static constexpr std::array words{"null", "true", "false", "yes", "no", "on", "off", "y", "n"};
  const auto same = [&](std::string_view word) {
    return std::equal(word.begin(), word.end(), text.begin(), text.end(),
                      [](char a, char b) { return a == (b >= 'A' && b <= 'Z' ? b - 'A' + 'a' : b); });
  };
  return std::any_of(words.begin(), words.end(), same);
}

/// Returns true for text that needs no quotes: it begins like a name, and no character in it is special to
/// YAML.
bool is_plain(std::string_view text) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_allowed = [&](char c) {
    return is_letter(c) || (c >= '0' && c <= '9') || c == '/' || c == '.' || c == '-' || c == ' ';
  };
  return !text.empty() && (is_letter(text.front()) || text.front() == '/') && text.back() != ' ' &&
         std::all_of(text.begin(), text.end(), is_allowed) && !is_word(text);
}

void append_hex(std::string& out, std::uint32_t value, int digits) {
  for (int shift = 4 * (digits - 1); shift >= 0; shift -= 4) out += "0123456789abcdef"[value >> shift & 0xf];
}

void append_escaped(std::string& out, std::uint32_t c) {
  switch (c) {
    case '\n':
      out += "\\n";
      return;
    case '\t':
      out += "\\t";
      return;
    case '\r':
      out += "\\r";
      return;
    case '"':
    case '\\':
      out += {'\\', static_cast<char>(c)};
      return;
    default:
      out += c < 0x100 ? "\\x" : c < 0x10000 ? "\\u" : "\\U";
      append_hex(out, c, c < 0x100 ? 2 : c < 0x10000 ? 4 : 8);
  }
}

void append_quoted(std::string& out, std::string_view text) {
  out += '"';
  while (!text.empty()) {
    const CodePoint next = first_code_point(text);
    const std::size_t bytes = std::max<std::size_t>(next.bytes, 1);
    if (next.bytes == 0) {
      append_escaped(out, static_cast<std::uint8_t>(text.front()));
    } else if (is_control(next.value) || next.value == '"' || next.value == '\\') {
      append_escaped(out, next.value);
    } else {
      out += text.substr(0, bytes);
    }
    text.remove_prefix(bytes);
  }
  out += '"';
}

template <class F>
void append_float(std::string& out, F value) {
  if (std::isnan(value)) {
    out += ".nan";
  } else if (std::isinf(value)) {
    out += value < 0 ? "-.inf" : ".inf";
  } else {
    std::array<char, 32> buffer{};
    const auto written = std::to_chars(buffer.begin(), buffer.end(), value);
    std::string digits(buffer.begin(), written.ptr);  // the fewest digits that identify the value
    if (digits.find('.') == std::string::npos) digits.insert(std::min(digits.find('e'), digits.size()), ".0");
    out += digits;
  }
}

/// Shortens the text to at most `most` bytes, without cutting a character of UTF-8.
std::string_view cut(std::string_view text, std::size_t most) {
  if (text.size() <= most) return text;
  while (most > 0 && (static_cast<std::uint8_t>(text[most]) & 0xc0U) == 0x80) --most;
  return text.substr(0, most);
}

class YamlWriter {
 public:
  explicit YamlWriter(const YamlOptions& options) : options_(options) {}

  Result<std::string> write(const DynamicView& view) {
    if (!view) {
      failure(view.error() != nullptr ? *view.error()
                                      : Error{Errc::unavailable, "the field was not sent in this sample"});
    } else if (view.is_struct()) {
      members(view, 0);
      if (out_.empty()) out_ = "{}\n";
    } else if (view.is_collection()) {
      member(view, 0);
    } else {
      scalar(view);
      out_ += '\n';
    }
    if (failure_) return tl::unexpected(*std::move(failure_));
    return std::move(out_);
  }

 private:
  void members(const DynamicView& view, std::size_t indent) {
    for (const DynamicView& m : view.members()) {
      if (m.is_absent()) continue;
      member(m, indent);
      if (failure_) return;
    }
  }

  void member(const DynamicView& m, std::size_t indent) {
    if (m.error() != nullptr) return failure(*m.error());
    line(indent);
    name(m);
    if (m.is_collection()) return collection(m, indent);
    out_ += ':';
    if (m.is_struct()) {
      comment(m, 0);
      out_ += '\n';
      return members(m, indent + 2);
    }
    out_ += ' ';
    const std::size_t more = scalar(m);
    comment(m, more);
    out_ += '\n';
  }

  /// Writes a member's name. Single letters, such as coordinates, get no quotes, since present-day readers do
  /// not take them for booleans.
  void name(const DynamicView& m) {
    if (m.name().size() > 1 && is_word(m.name()) && !m.has_only_size()) {
      append_quoted(out_, m.name());
    } else {
      out_ += m.name();
    }
  }

  void collection(const DynamicView& m, std::size_t indent) {
    const Result<std::size_t> size = m.size();
    if (!size) return failure(size.error());
    if (m.has_only_size()) {
      out_ += ".size: " + std::to_string(*size) + '\n';
    } else if (*size == 0) {
      out_ += ": []\n";
    } else if (is_primitive(m.kind())) {
      flow(m, *size);
    } else {
      block(m, *size, indent);
    }
  }

  void flow(const DynamicView& m, std::size_t size) {
    std::size_t printed = 0;
    out_ += ": [";
    for (const DynamicView& element : m.elements()) {
      if (printed == options_.elements_max || failure_) break;
      if (printed++ != 0) out_ += ", ";
      scalar(element);
      check_length();
    }
    out_ += ']';
    // The size is limited, because shared memory may have changed meanwhile.
    comment(m, size - std::min(size, printed));
    out_ += '\n';
  }

  void block(const DynamicView& m, std::size_t size, std::size_t indent) {
    std::size_t printed = 0;
    out_ += ':';
    comment(m, 0);
    out_ += '\n';
    for (const DynamicView& element : m.elements()) {
      if (printed == options_.elements_max || failure_) break;
      ++printed;
      dash_ = true;
      if (element.error() != nullptr) {
        failure(*element.error());
      } else if (element.is_struct()) {
        members(element, indent + 2);
      } else {
        line(indent + 2);
        const std::size_t more = scalar(element);
        comment({}, more);
        out_ += '\n';
      }
    }
    dash_ = false;
    if (printed >= size) return;
    out_.append(indent, ' ');
    out_ += "# ... " + std::to_string(size - printed) + " more\n";
  }

  /// Begins a line. The first line of a sequence's element has a dash in its indentation.
  void line(std::size_t indent) {
    check_length();
    out_.append(dash_ ? indent - 2 : indent, ' ');
    if (dash_) out_ += "- ";
    dash_ = false;
  }

  void check_length() {
    if (out_.size() <= options_.output_bytes_max) return;
    failure({Errc::limit_exceeded, "the text would have more than " +
                                       std::to_string(options_.output_bytes_max) +
                                       " bytes; lower the limit of elements"});
  }

  void comment(const DynamicView& m, std::size_t more) {
    comment(options_.units && m.member() != nullptr ? m.member()->unit : std::string_view(), more);
  }

  void comment(std::string_view unit, std::size_t more) {
    if (unit.empty() && more == 0) return;
    out_ += "  # ";
    out_ += unit;
    if (!unit.empty() && more != 0) out_ += ", ";
    if (more != 0) out_ += "... " + std::to_string(more) + " more";
  }

  /// Writes a scalar. Returns the number of bytes of a text that were left out.
  std::size_t scalar(const DynamicView& view) {
    const Result<DynamicView::Scalar> value = view.scalar();
    if (!value) {
      failure(value.error());
      return 0;
    }
    if (view.member()->enumeration != nullptr) {
      if (const auto symbol = view.enumerator()) return text(*symbol);
    }
    return std::visit([this](const auto& v) { return print(v); }, *value);
  }

  std::size_t print(bool v) { return append(v ? "true" : "false"); }
  std::size_t print(char v) { return text({&v, 1}); }
  std::size_t print(std::int64_t v) { return append(std::to_string(v)); }
  std::size_t print(std::uint64_t v) { return append(std::to_string(v)); }
  std::size_t print(std::string_view v) { return text(v); }
  template <std::floating_point F>
  std::size_t print(F v) {
    append_float(out_, v);
    return 0;
  }

  std::size_t append(std::string_view v) {
    out_ += v;
    return 0;
  }

  std::size_t text(std::string_view whole) {
    const std::string_view text = cut(whole, options_.text_bytes_max);
    if (is_plain(text)) {
      out_ += text;
    } else {
      append_quoted(out_, text);
    }
    return whole.size() - text.size();
  }

  void failure(const Error& error) {
    if (!failure_) failure_ = error;
  }

  const YamlOptions& options_;
  std::string out_;
  bool dash_ = false;
  std::optional<Error> failure_;
};

}  // namespace

Result<std::string> to_yaml(const DynamicView& view, const YamlOptions& options) {
  return YamlWriter(options).write(view);
}

}  // namespace sft
