// What a user's configuration of Cyclone DDS (CYCLONEDDS_URI) sets for a domain, as Cyclone will understand
// it. It takes more than XML: `</>` closes any element, ends may be missing, and outside of files names may
// be shortened and the outer elements left out. So this reads with the parser that Cyclone itself uses, and
// by its rules for names.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sft/typesupport/result.h"

namespace sft::core {

/// As names and values of settings are compared: upper and lower case are the same.
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
  /// Of an element that may be there several times; in order.
  std::vector<std::string> values(std::string_view path) const;
  /// Whether anything is set there or below.
  bool sets(std::string_view path) const;
  /// There are settings, and all of them are for other domains.
  bool only_for_others() const { return settings_.empty() && for_others_; }

 private:
  friend class CycloneSettingsReader;
  struct Setting {
    std::vector<std::string> path;
    std::string value;
    bool may_be_short = false;  ///< names in its path may be
  };
  static bool is_at(const Setting& setting, std::string_view path);

  std::vector<Setting> settings_;
  bool for_others_ = false;
};

}  // namespace sft::core
