// The settings that a user's configuration of Cyclone DDS (CYCLONEDDS_URI) makes for a domain, as Cyclone
// will understand them. Cyclone takes more than XML: `</>` closes any element, ends may be missing, and
// outside of files names may be shortened and the outer elements left out. So this class reads with the
// parser that Cyclone itself uses, and by its rules for names.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sft/result.h"

namespace sft::core {

/// Compares names and values of settings: upper and lower case are the same.
bool equals(std::string_view a, std::string_view b);

/// An element of the configuration. Its attributes are elements, too, whose names begin with "@".
struct CycloneElement {
  std::string name;
  bool may_be_short = false;           ///< the name may lack its end
  std::optional<std::string> value{};  ///< nothing if the element has no text
  std::vector<CycloneElement> elements{};
};

class CycloneSettings {
 public:
  /// `config`: XML texts and names of files (or file:// URIs), separated by commas; may be empty. The error
  /// names the file that cannot be read, or the place that cannot be parsed; names that Cyclone does not know
  /// are not looked for.
  static Result<CycloneSettings> read(const std::string& config, std::uint32_t domain);

  /// Paths are those of Cyclone's documentation, below <Domain>: "General/FragmentSize"; an attribute is
  /// "@name". What is set twice holds as it is set last.
  std::optional<std::string> value(std::string_view path) const;
  /// Returns the values of an element that may be there several times, in order.
  std::vector<std::string> values(std::string_view path) const;
  /// True if anything is set there or below.
  bool sets(std::string_view path) const;
  /// There are settings, and all of them are for other domains.
  bool only_for_others() const;

  /// The configuration once more, for a Cyclone domain that has another number inside of the process: for any
  /// domain, with variables replaced, and without what is set at or below the paths of `left_out`.
  std::string for_any_domain(const std::vector<std::string_view>& left_out) const;
  /// False if Cyclone would understand the user's own text as for_any_domain({}) does. That text is better
  /// then, since messages name the lines of it.
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
