// The settings that a user's configuration of Cyclone DDS (CYCLONEDDS_URI) makes for a domain, in the way
// in which Cyclone will understand them. Cyclone accepts more than XML: `</>` closes any element, closing
// tags may be missing, and outer elements may be left out. So this class uses Cyclone's own parser. Settings
// under shortened or former names, which Cyclone also accepts, are passed on, but are not found by their
// paths.
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

/// An element of the configuration. Attributes are stored as elements whose names begin with "@".
struct CycloneElement {
  std::string name;
  std::optional<std::string> value{};  ///< nothing if the element has no text
  std::vector<CycloneElement> elements{};
};

class CycloneSettings {
 public:
  /// `config`: XML texts and names of files (or file:// URIs), separated by commas; may be empty. The error
  /// names the file that cannot be read, or the part of the text that cannot be parsed. Names of settings
  /// that Cyclone does not know are no error.
  static Result<CycloneSettings> read(const std::string& config, std::uint32_t domain);

  /// Returns the value of an element. Paths are those of Cyclone's documentation, relative to <Domain>,
  /// such as "General/FragmentSize". An attribute is "@name". If a setting occurs twice, the last value
  /// holds.
  std::optional<std::string> value(std::string_view path) const;
  /// Returns the values of an element that may occur several times, in order.
  std::vector<std::string> values(std::string_view path) const;
  /// Returns true if the configuration sets the element at the path, or any element inside it.
  bool sets(std::string_view path) const;
  /// Returns true if the configuration has settings, but none of them applies to this domain.
  bool only_for_others() const;

  /// Returns the configuration as text that applies to any domain, since links have other domain numbers
  /// within this process. Variables are replaced. The elements at the paths of `left_out`, and all elements
  /// inside them, are omitted.
  std::string for_any_domain(const std::vector<std::string_view>& left_out) const;
  /// Returns false if the user's own text and for_any_domain({}) mean the same to Cyclone. Pass the user's
  /// text to Cyclone then, because Cyclone's messages name its lines.
  bool depends_on_domain() const { return depends_on_domain_; }

 private:
  explicit CycloneSettings(std::uint32_t domain) : domain_(domain) {}
  Result<std::size_t> read_document(const std::string& text, const std::string& source, unsigned leniency);
  void add_domain(const CycloneElement& element);
  bool is_for_us(const std::string& id);
  std::vector<const CycloneElement*> at(std::string_view path) const;

  std::uint32_t domain_;
  CycloneElement all_{};  ///< the groups of settings for this domain
  bool has_others_ = false;
  bool depends_on_domain_ = false;
};

}  // namespace sft::core
