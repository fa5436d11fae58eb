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
#include <utility>
#include <vector>

#include "sft/result.h"

namespace sft::core {

/// Compares names or values of settings, ignoring case.
bool equals(std::string_view a, std::string_view b);

/// Returns the element as XML.
std::string xml_element(std::string_view name, std::string_view content);
/// Returns a configuration with these groups of settings that applies to any domain.
std::string xml_document(std::string_view groups);

/// The number of the domain on the network, where it is not that within the process.
inline constexpr std::string_view domain_number_path = "Discovery/ExternalDomainId";

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

  /// Returns true if the configuration has DDS Security.
  bool is_secured() const;
  /// Returns the number of the domain on the network.
  std::string domain_on_wire() const;

  /// Returns the configuration as text that applies to any domain, since links have other domain numbers
  /// within this process. The elements at the paths of `left_out`, and all elements inside them, are omitted.
  /// Where that changes nothing, this is the user's own text, because Cyclone's messages name its lines.
  std::string for_any_domain(const std::vector<std::string_view>& left_out) const;

 private:
  CycloneSettings(std::string text, std::uint32_t domain) : text_(std::move(text)), domain_(domain) {}
  Result<std::size_t> read_document(const std::string& text, const std::string& source, unsigned leniency);
  void add_domain(const CycloneElement& element);
  bool is_for_us(const std::string& id);
  std::vector<const CycloneElement*> at(std::string_view path) const;

  std::string text_;
  std::uint32_t domain_;
  CycloneElement all_{};  ///< the groups of settings for this domain
  bool has_others_ = false;
  bool depends_on_domain_ = false;  ///< the text means something else to a domain with another number
};

}  // namespace sft::core
