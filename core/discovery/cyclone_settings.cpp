#include "core/discovery/cyclone_settings.h"

#include <dds/ddsrt/environ.h>
#include <dds/ddsrt/heap.h>
#include <dds/ddsrt/xmlparser.h>
#include <strings.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <memory>
#include <ranges>

namespace sft::core {

namespace {

struct FileCloser {
  void operator()(std::FILE* file) const { std::fclose(file); }
};
struct ParserDeleter {
  void operator()(ddsrt_xmlp_state* parser) const { ddsrt_xmlp_free(parser); }
};
using File = std::unique_ptr<std::FILE, FileCloser>;
using Parser = std::unique_ptr<ddsrt_xmlp_state, ParserDeleter>;

constexpr std::string_view separators = ", \t\r\n";
constexpr const char* where_from =
    "the configuration of Cyclone DDS (CYCLONEDDS_URI or NodeOptions::cyclonedds_config)";

bool is_called(std::string_view written, std::string_view name, bool may_be_short) {
  const bool is_short = may_be_short && !written.empty() && written.size() < name.size();
  return equals(written, is_short ? name.substr(0, written.size()) : name);
}

/// Returns the value with ${VARIABLES} replaced.
std::string expanded(const char* value, std::uint32_t domain) {
  const std::unique_ptr<char, void (*)(void*)> text(ddsrt_expand_envvars(value, domain), &ddsrt_free);
  return text == nullptr ? value : text.get();
}

/// Replaces a former path by the one where Cyclone finds the setting now.
void bring_up_to_date(std::vector<std::string>& path) {
  if (path.empty()) return;
  if (equals(path[0], "Unsupported")) path[0] = "Internal";
  if (equals(path[0], "DDSSecurity")) path[0] = "Security";
  const bool moved =
      path.size() > 1 && (equals(path[1], "MaxMessageSize") || equals(path[1], "FragmentSize"));
  if (moved && equals(path[0], "Internal")) path[0] = "General";
}

}  // namespace

bool equals(std::string_view a, std::string_view b) {
  return a.size() == b.size() && strncasecmp(a.data(), b.data(), a.size()) == 0;
}

/// Hears what the parser finds, in one text or file.
class CycloneSettingsReader {
 public:
  CycloneSettingsReader(CycloneSettings& settings, std::uint32_t domain, bool is_file)
      : settings_(settings), domain_(domain), may_be_short_(!is_file) {}

  static const ddsrt_xmlp_callbacks& callbacks() {
    static constexpr ddsrt_xmlp_callbacks all{&on_open, &on_attribute, &on_data, &on_close, &on_error};
    return all;
  }
  const std::string& error() const { return error_; }

 private:
  static CycloneSettingsReader& self(void* reader) { return *static_cast<CycloneSettingsReader*>(reader); }
  static int on_open(void* reader, std::uintptr_t, std::uintptr_t*, const char* name, int) {
    self(reader).open_.emplace_back(name);
    return 1;
  }
  static int on_attribute(void* reader, std::uintptr_t, const char* name, const char* value, int) {
    self(reader).set(std::string("@") + name, value);
    return 1;
  }
  static int on_data(void* reader, std::uintptr_t, const char* value, int) {
    self(reader).set("", value);
    return 1;
  }
  static int on_close(void* reader, std::uintptr_t, int) {
    self(reader).close();
    return 1;
  }
  static void on_error(void* reader, const char* message, int line) {
    self(reader).error_ = "line " + std::to_string(line) + ": " + message;
  }

  void close() {
    open_.pop_back();
    if (kept_.size() > open_.size()) kept_.resize(open_.size());
    if (open_.size() < skipped_from_) skipped_from_ = nothing_skipped;
  }

  /// The elements around <Domain>, and <Domain> itself, are left out of the path.
  void set(std::string attribute, const char* value) {
    if (open_.size() >= skipped_from_) return;
    std::size_t outer = equals(open_[0], "CycloneDDS") ? 1 : 0;
    bool in_domain = false;
    if (open_.size() > outer && (is_called(open_[outer], "Domain", may_be_short_ && outer == 1) ||
                                 equals(open_[outer], "DDSI2E") || equals(open_[outer], "DDSI2"))) {
      in_domain = true;
      ++outer;
    }
    CycloneSettings::Setting setting{{open_.begin() + static_cast<std::ptrdiff_t>(outer), open_.end()},
                                     expanded(value, domain_),
                                     may_be_short_};
    if (!attribute.empty()) setting.path.push_back(std::move(attribute));
    if (setting.path.empty()) return;
    const bool is_id =
        setting.path.size() == 1 && (equals(setting.path[0], "@Id") || equals(setting.path[0], "Id"));
    settings_.depends_on_domain_ |= setting.value != value;
    if (in_domain && is_id) return take_id(setting.value, outer);
    if (outer < open_.size()) {  // and not a name space, say
      keep(setting, outer);
      bring_up_to_date(setting.path);
      settings_.settings_.push_back(std::move(setting));
    }
  }

  /// Puts a setting into the tree, at the elements that are open.
  void keep(const CycloneSettings::Setting& setting, std::size_t outer) {
    std::vector<CycloneSettings::Element>* among = &settings_.elements_;
    CycloneSettings::Element* element = nullptr;
    for (std::size_t depth = outer; depth < open_.size(); ++depth) {
      if (depth >= kept_.size() || kept_[depth] == not_kept || kept_[depth] >= among->size()) {
        kept_.resize(std::max(kept_.size(), depth + 1), not_kept);
        kept_[depth] = among->size();
        among->push_back({.name = open_[depth], .may_be_short = may_be_short_});
      }
      element = &(*among)[kept_[depth]];
      among = &element->elements;
    }
    const std::string& last = setting.path.back();
    if (last.starts_with('@')) {
      element->attributes.emplace_back(last.substr(1), setting.value);
    } else {
      element->value += setting.value;
    }
  }

  void take_id(const std::string& id, std::size_t domain_depth) {
    std::uint32_t number = 0;
    const auto [end, error] = std::from_chars(id.data(), id.data() + id.size(), number);
    const bool is_number = error == std::errc{} && end == id.data() + id.size();
    settings_.depends_on_domain_ |= is_number;
    if (equals(id, "any") || !is_number || number == domain_) return;  // what is neither, Cyclone refuses
    settings_.for_others_ = true;
    settings_.depends_on_domain_ = true;
    skipped_from_ = domain_depth;
  }

  static constexpr std::size_t nothing_skipped = SIZE_MAX;
  static constexpr std::size_t not_kept = SIZE_MAX;

  CycloneSettings& settings_;
  const std::uint32_t domain_;
  const bool may_be_short_;
  std::vector<std::string> open_;
  std::vector<std::size_t> kept_;               ///< for each open element: its place in the tree
  std::size_t skipped_from_ = nothing_skipped;  ///< while so many elements are open
  std::string error_;
};

namespace {

Result<void> parse(const Parser& parser, const CycloneSettingsReader& reader, const std::string& source) {
  if (ddsrt_xmlp_parse(parser.get()) >= 0) return {};
  return fail(Errc::invalid_argument, source + " is malformed: " + reader.error());
}

Result<void> read_file(const std::string& name, CycloneSettings& settings, std::uint32_t domain) {
  constexpr std::string_view scheme = "file://";
  File file(std::fopen(name.c_str(), "re"));
  if (file == nullptr && name.starts_with(scheme)) file.reset(std::fopen(name.c_str() + scheme.size(), "re"));
  if (file == nullptr) {
    return fail(Errc::invalid_argument, std::string(where_from) + " names the file '" + name +
                                            "', which cannot be read: " + std::strerror(errno));
  }
  CycloneSettingsReader reader(settings, domain, true);
  const Parser parser(ddsrt_xmlp_new_file(file.get(), &reader, &CycloneSettingsReader::callbacks()));
  return parse(parser, reader, "the file '" + name + "'");
}

/// Returns where the text ends.
Result<std::size_t> read_text(const std::string& text, CycloneSettings& settings, std::uint32_t domain) {
  CycloneSettingsReader reader(settings, domain, false);
  const Parser parser(ddsrt_xmlp_new_string(text.c_str(), &reader, &CycloneSettingsReader::callbacks()));
  ddsrt_xmlp_set_options(parser.get(), DDSRT_XMLP_ANONYMOUS_CLOSE_TAG | DDSRT_XMLP_MISSING_CLOSE_AS_EOF);
  return parse(parser, reader, where_from).map([&] { return ddsrt_xmlp_get_bufpos(parser.get()); });
}

}  // namespace

Result<CycloneSettings> CycloneSettings::read(const std::string& config, std::uint32_t domain) {
  CycloneSettings settings;
  for (std::size_t at = config.find_first_not_of(separators); at < config.size();
       at = config.find_first_not_of(separators, at)) {
    if (config[at] == '<') {
      const Result<std::size_t> bytes = read_text(config.substr(at), settings, domain);
      if (!bytes) return tl::unexpected(bytes.error());
      at += *bytes;
    } else {
      const std::size_t end = std::min(config.find(',', at), config.size());
      if (const auto read = read_file(config.substr(at, end - at), settings, domain); !read)
        return tl::unexpected(read.error());
      at = end;
    }
  }
  return settings;
}

/// There or below.
bool CycloneSettings::is_at(const Setting& setting, std::string_view path) {
  std::size_t depth = 0;
  for (const auto part : std::views::split(path, '/')) {
    const std::string_view name(part.begin(), part.end());
    if (depth == setting.path.size() || !is_called(setting.path[depth], name, setting.may_be_short))
      return false;
    ++depth;
  }
  return true;
}

std::vector<std::string> CycloneSettings::values(std::string_view path) const {
  const auto depth = static_cast<std::size_t>(std::ranges::count(path, '/')) + 1;
  std::vector<std::string> found;
  for (const Setting& setting : settings_) {
    if (setting.path.size() == depth && is_at(setting, path)) found.push_back(setting.value);
  }
  return found;
}

std::optional<std::string> CycloneSettings::value(std::string_view path) const {
  const std::vector<std::string> all = values(path);
  return all.empty() ? std::nullopt : std::optional(all.back());
}

namespace {
std::string in_xml(std::string_view text) {
  std::string result;
  for (const char c : text) {
    switch (c) {
      case '&':
        result += "&amp;";
        break;
      case '<':
        result += "&lt;";
        break;
      case '>':
        result += "&gt;";
        break;
      case '"':
        result += "&quot;";
        break;
      default:
        result += c;
    }
  }
  return result;
}
}  // namespace

void CycloneSettings::write(const Element& element, std::vector<std::string>& path,
                            const std::vector<std::string_view>& left_out, std::string& text) {
  path.push_back(element.name);
  Setting here{path, {}, element.may_be_short};
  bring_up_to_date(here.path);
  const bool is_left_out = std::ranges::any_of(left_out, [&](std::string_view one) {
    return static_cast<std::size_t>(std::ranges::count(one, '/')) + 1 == path.size() && is_at(here, one);
  });
  if (!is_left_out) {
    text += "<" + element.name;
    for (const auto& [name, value] : element.attributes) text += " " + name + "=\"" + in_xml(value) + "\"";
    text += ">" + in_xml(element.value);
    for (const Element& inner : element.elements) write(inner, path, left_out, text);
    text += "</" + element.name + ">";
  }
  path.pop_back();
}

std::string CycloneSettings::for_any_domain(const std::vector<std::string_view>& left_out) const {
  std::string text = "<CycloneDDS><Domain id=\"any\">";
  std::vector<std::string> path;
  for (const Element& element : elements_) write(element, path, left_out, text);
  return text + "</Domain></CycloneDDS>";
}

bool CycloneSettings::sets(std::string_view path) const {
  return std::ranges::any_of(settings_, [&](const Setting& setting) { return is_at(setting, path); });
}

}  // namespace sft::core
