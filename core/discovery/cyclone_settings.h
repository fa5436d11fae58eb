// The settings that a user's configuration of Cyclone DDS (CYCLONEDDS_URI) makes for a domain, as Cyclone
// will understand them. Cyclone takes more than XML: `</>` closes any element, ends may be missing, and
// outside of files names may be shortened and the outer elements left out. So this class reads with the
// parser that Cyclone itself uses, and by its rules for names.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "sft/result.h"

namespace sft::core {

/// Compares names and values of settings: upper and lower case are the same.
bool equals(std::string_view a, std::string_view b);

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
  bool only_for_others() const { return settings_.empty() && for_others_; }

  /// The configuration once more, for a Cyclone domain that has another number inside of the process: for any
  /// domain, with variables replaced, and without what is set at or below the paths of `left_out`.
  std::string for_any_domain(const std::vector<std::string_view>& left_out) const;
  /// False if Cyclone would understand the user's own text as for_any_domain({}) does. That text is better
  /// then, since messages name the lines of it.
  bool depends_on_domain() const { return depends_on_domain_; }

 private:
  friend class CycloneSettingsReader;
  struct Setting {
    std::vector<std::string> path;
    std::string value;
    bool may_be_short = false;  ///< names in its path may be
  };
  /// An element of the configuration below <Domain>.
  struct Element {
    std::string name;
    std::vector<std::pair<std::string, std::string>> attributes{};
    std::string value{};
    std::vector<Element> elements{};
    bool may_be_short = false;
  };
  static bool is_at(const Setting& setting, std::string_view path);
  static void write(const Element& element, std::vector<std::string>& path,
                    const std::vector<std::string_view>& left_out, std::string& text);

  std::vector<Setting> settings_;
  std::vector<Element> elements_;
  bool for_others_ = false;
  bool depends_on_domain_ = false;
};

}  // namespace sft::core
