#include "core/discovery/cyclone_settings.h"

#include <dds/ddsrt/environ.h>
#include <dds/ddsrt/heap.h>
#include <dds/ddsrt/xmlparser.h>
#include <strings.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cstring>
#include <memory>
#include <ranges>
#include <utility>

#include "core/platform/text_file.h"

namespace sft::core {

namespace {

struct ParserDeleter {
  void operator()(ddsrt_xmlp_state* parser) const { ddsrt_xmlp_free(parser); }
};
using Parser = std::unique_ptr<ddsrt_xmlp_state, ParserDeleter>;

constexpr std::string_view separators = ", \t\r\n";
constexpr const char* where_from =
    "the configuration of Cyclone DDS (CYCLONEDDS_URI or NodeOptions::cyclonedds_config)";

/// Returns the value with ${VARIABLES} replaced.
std::string expanded(const char* value, std::uint32_t domain) {
  const std::unique_ptr<char, void (*)(void*)> text(ddsrt_expand_envvars(value, domain), &ddsrt_free);
  return text == nullptr ? value : text.get();
}

bool sets_anything(const CycloneElement& element) {
  return element.value || std::ranges::any_of(element.elements, sets_anything);
}

/// Builds a tree of the elements that the parser finds in one text or file.
class DocumentReader {
 public:
  explicit DocumentReader(std::uint32_t domain) : domain_(domain) {}

  static const ddsrt_xmlp_callbacks& callbacks() {
    static constexpr ddsrt_xmlp_callbacks all{&on_open, &on_attribute, &on_data, &on_close, &on_error};
    return all;
  }
  /// Returns a root element that contains the outermost elements of the text. The error begins with
  /// `source`, and names the malformed part.
  Result<CycloneElement> parse(const Parser& parser, const std::string& source) {
    if (ddsrt_xmlp_parse(parser.get()) < 0)
      return fail(Errc::invalid_argument, source + " is malformed: " + error_);
    return open_.front();
  }
  bool has_variables() const { return has_variables_; }

 private:
  static DocumentReader& self(void* reader) { return *static_cast<DocumentReader*>(reader); }
  /// The parser of Cyclone DDS calls itself for each element within another one, and would use up the stack.
  static constexpr std::size_t depth_max = 100;
  static int on_open(void* reader, std::uintptr_t, std::uintptr_t*, const char* name, int line) {
    if (self(reader).open_.size() > depth_max) {
      on_error(reader, "elements are nested too deeply", line);
      return -1;
    }
    self(reader).open_.push_back({.name = name});
    return 1;
  }
  static int on_attribute(void* reader, std::uintptr_t, const char* name, const char* value, int) {
    on_open(reader, 0, nullptr, (std::string("@") + name).c_str(), 0);
    on_data(reader, 0, value, 0);
    return on_close(reader, 0, 0);
  }
  static int on_data(void* reader, std::uintptr_t, const char* text, int) {
    std::string value = expanded(text, self(reader).domain_);
    self(reader).has_variables_ |= value != text;
    self(reader).open_.back().value = std::move(value);
    return 1;
  }
  static int on_close(void* reader, std::uintptr_t, int) {
    std::vector<CycloneElement>& open = self(reader).open_;
    CycloneElement element = std::move(open.back());
    open.pop_back();
    open.back().elements.push_back(std::move(element));
    return 1;
  }
  static void on_error(void* reader, const char* message, int line) {
    std::string& error = self(reader).error_;  // the first one is the most precise
    if (error.empty()) error = "line " + std::to_string(line) + ": " + message;
  }

  const std::uint32_t domain_;
  std::vector<CycloneElement> open_{1};  ///< the elements that are not closed yet; the first one is the root
  bool has_variables_ = false;
  std::string error_;
};

std::string in_xml(std::string_view text) {
  constexpr std::string_view special = "&<>\"";
  constexpr std::array instead{"&amp;", "&lt;", "&gt;", "&quot;"};
  std::string result;
  for (const char c : text) {
    const std::size_t which = special.find(c);
    if (which == std::string_view::npos) {
      result += c;
    } else {
      result += instead[which];
    }
  }
  return result;
}

void write(const CycloneElement& element, const std::vector<const CycloneElement*>& left_out,
           std::string& text) {
  if (std::ranges::find(left_out, &element) != left_out.end()) return;
  const auto is_attribute = [](const CycloneElement& one) { return one.name.starts_with('@'); };
  text += "<" + element.name;
  for (const CycloneElement& one : element.elements) {
    if (is_attribute(one)) text += " " + one.name.substr(1) + "=\"" + in_xml(*one.value) + "\"";
  }
  text += ">" + in_xml(element.value.value_or(""));
  for (const CycloneElement& one : element.elements) {
    if (!is_attribute(one)) write(one, left_out, text);
  }
  text += "</" + element.name + ">";
}

Result<std::string> text_of_file(const std::string& name) {
  constexpr std::string_view scheme = "file://";
  Result<std::string> text = read_text_file(name.starts_with(scheme) ? name.substr(scheme.size()) : name);
  if (!text)
    return fail(Errc::invalid_argument,
                std::string(where_from) + " names '" + name + "': " + text.error().message);
  return text;
}

}  // namespace

bool equals(std::string_view a, std::string_view b) {
  return a.size() == b.size() && strncasecmp(a.data(), b.data(), a.size()) == 0;
}

std::string xml_element(std::string_view name, std::string_view content) {
  return "<" + std::string(name) + ">" + std::string(content) + "</" + std::string(name) + ">";
}

std::string xml_document(std::string_view groups) {
  return "<CycloneDDS><Domain id=\"any\">" + std::string(groups) + "</Domain></CycloneDDS>";
}

Result<CycloneSettings> CycloneSettings::read(const std::string& config, std::uint32_t domain) {
  CycloneSettings settings(config, domain);
  for (std::size_t at = config.find_first_not_of(separators); at < config.size();
       at = config.find_first_not_of(separators, at)) {
    if (config[at] == '<') {
      const Result<std::size_t> bytes = settings.read_document(
          config.substr(at), where_from, DDSRT_XMLP_ANONYMOUS_CLOSE_TAG | DDSRT_XMLP_MISSING_CLOSE_AS_EOF);
      if (!bytes) return tl::unexpected(bytes.error());
      at += *bytes;
      continue;
    }
    const std::size_t end = std::min(config.find(',', at), config.size());
    const std::string name = config.substr(at, end - at);
    const Result<std::string> text = text_of_file(name);
    if (!text) return tl::unexpected(text.error());
    if (const auto read = settings.read_document(*text, "the file '" + name + "'", 0); !read)
      return tl::unexpected(read.error());
    at = end;
  }
  return settings;
}

/// Adds the settings of the XML document at the beginning of `text`. Returns the offset at which the document
/// ends. The elements around the groups of settings, <CycloneDDS> and <Domain>, may be missing.
Result<std::size_t> CycloneSettings::read_document(const std::string& text, const std::string& source,
                                                   unsigned leniency) {
  DocumentReader reader(domain_);
  const Parser parser(ddsrt_xmlp_new_string(text.c_str(), &reader, &DocumentReader::callbacks()));
  ddsrt_xmlp_set_options(parser.get(), leniency);
  return reader.parse(parser, source).map([&](const CycloneElement& document) {
    depends_on_domain_ |= reader.has_variables();
    for (const CycloneElement& outer : document.elements) {
      if (!equals(outer.name, "CycloneDDS")) {
        add_domain(outer);
        continue;
      }
      for (const CycloneElement& inner : outer.elements) add_domain(inner);
    }
    return ddsrt_xmlp_get_bufpos(parser.get());
  });
}

/// Attributes of outer elements are left out; one may be an XML namespace, for example.
void CycloneSettings::add_domain(const CycloneElement& element) {
  if (!equals(element.name, "Domain") && !equals(element.name, "DDSI2E") && !equals(element.name, "DDSI2")) {
    if (!element.name.starts_with('@')) all_.elements.push_back(element);
    return;
  }
  for (const CycloneElement& one : element.elements) {
    const bool is_id = equals(one.name, "@Id") || equals(one.name, "Id");
    if (is_id && one.value && !is_for_us(*one.value)) return;
    if (!is_id && !one.name.starts_with('@')) all_.elements.push_back(one);
  }
}

bool CycloneSettings::is_for_us(const std::string& id) {
  std::uint32_t number = 0;
  const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), number);
  const bool is_number = error == std::errc{} && end == id.data() + id.size();
  depends_on_domain_ |= is_number;
  if (equals(id, "any") || !is_number || number == domain_) return true;  // Cyclone refuses other ids
  has_others_ = true;
  return false;
}

std::vector<const CycloneElement*> CycloneSettings::at(std::string_view path) const {
  std::vector<const CycloneElement*> found{&all_};
  for (const auto part : std::views::split(path, '/')) {
    const std::string_view name(part.begin(), part.end());
    std::vector<const CycloneElement*> inner;
    for (const CycloneElement* outer : found) {
      for (const CycloneElement& one : outer->elements) {
        if (equals(one.name, name)) inner.push_back(&one);
      }
    }
    found = std::move(inner);
  }
  return found;
}

std::vector<std::string> CycloneSettings::values(std::string_view path) const {
  std::vector<std::string> values;
  for (const CycloneElement* one : at(path)) {
    if (one->value) values.push_back(*one->value);
  }
  return values;
}

std::optional<std::string> CycloneSettings::value(std::string_view path) const {
  const std::vector<std::string> all = values(path);
  return all.empty() ? std::nullopt : std::optional(all.back());
}

bool CycloneSettings::sets(std::string_view path) const {
  return std::ranges::any_of(at(path), [](const CycloneElement* one) { return sets_anything(*one); });
}

/// Older releases of Cyclone had another name for the group.
bool CycloneSettings::is_secured() const { return sets("Security") || sets("DDSSecurity"); }

std::string CycloneSettings::domain_on_wire() const {
  const std::string number = value(domain_number_path).value_or("default");
  return equals(number, "default") ? std::to_string(domain_) : number;
}

bool CycloneSettings::only_for_others() const { return has_others_ && !sets_anything(all_); }

std::string CycloneSettings::for_any_domain(const std::vector<std::string_view>& left_out) const {
  const auto is_set = [&](std::string_view path) { return sets(path); };
  if (!depends_on_domain_ && std::ranges::none_of(left_out, is_set)) return text_;
  std::vector<const CycloneElement*> skipped;
  for (const std::string_view path : left_out) std::ranges::copy(at(path), std::back_inserter(skipped));
  std::string groups;
  for (const CycloneElement& group : all_.elements) write(group, skipped, groups);
  return xml_document(groups);
}

}  // namespace sft::core
