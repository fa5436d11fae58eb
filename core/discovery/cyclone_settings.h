// The settings that a user's configuration of Cyclone DDS (CYCLONEDDS_URI) makes for a domain, as Cyclone
// will understand them. Cyclone accepts more than XML: `</>` closes any element, and closing tags may be
// missing. Outside of files, names may be shortened and the outer elements left out. So this class uses
// Cyclone's own parser, and its rules for names.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sft/result.h"

namespace sft::core {

/// Compares names or values of settings, ignoring case.
bool equals(std::string_view a, std::string_view b);

/// An element of the configuration. Its attributes are elements, too, whose names begin with "@".
struct CycloneElement {
  std::string name;
  bool may_be_short = false;           ///< the name may be shortened to its beginning
  std::optional<std::string> value{};  ///< nothing if the element has no text
  std::vector<CycloneElement> elements{};
};

class CycloneSettings {
 public:
  /// `config`: XML texts and names of files (or file:// URIs), separated by commas; may be empty. The error
  /// names the file that cannot be read, or the place that cannot be parsed. Names that Cyclone does not know
  /// are no error.
  static Result<CycloneSettings> read(const std::string& config, std::uint32_t domain);

  /// Returns the value of an element. Paths are those of Cyclone's documentation, below <Domain>:
  /// "General/FragmentSize"; an attribute is "@name". If a setting occurs twice, the last value holds.
  std::optional<std::string> value(std::string_view path) const;
  /// Returns the values of an element that may occur several times, in order.
  std::vector<std::string> values(std::string_view path) const;
  /// Returns true if anything is set at the path or below.
  bool sets(std::string_view path) const;
  /// Returns true if there are settings, but all of them are for other domains.
  bool only_for_others() const;

  /// Returns the configuration for a Cyclone domain that has another number inside of the process. It applies
  /// to any domain, has its variables replaced, and omits what is set at or below the paths of `left_out`.
  std::string for_any_domain(const std::vector<std::string_view>& left_out) const;
  /// Returns false if Cyclone understands the user's own text in the same way as for_any_domain({}). The
  /// user's text is preferable then, because messages name its lines.
  bool depends_on_domain() const { return depends_on_domain_; }

 private:
  explicit CycloneSettings(std::uint32_t domain) : domain_(domain) {}
  Result<std::size_t> read_text(const std::string& text);
  Result<void> read_file(const std::string& name);
  void add_document(const CycloneElement& document, bool has_variables);
  void add_domain(const CycloneElement& element, bool may_be_short);
  void add_group(CycloneElement group);
  bool is_for_us(const std::string& id);
  std::vector<const CycloneElement*> at(std::string_view path) const;

  std::uint32_t domain_;
  CycloneElement all_{};  ///< the groups of settings for this domain
  bool has_others_ = false;
  bool depends_on_domain_ = false;
};

}  // namespace sft::core
