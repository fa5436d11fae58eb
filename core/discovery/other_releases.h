// Whom a node sees and cannot speak with: nodes whose control topics are of another version. That they are
// there is said to people, and however many somebody makes up, no more than one line in a while. Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "core/discovery/speakers.h"
#include "core/platform/clock.h"

namespace sft::core {

class OtherReleases {
 public:
  static constexpr std::chrono::minutes pause{1};  ///< from one report to the next
  static constexpr std::size_t known_max = 256;

  /// A participant that says so, each time that it says so.
  void seen(const Speaker& speaker, std::uint32_t version);
  void left(const Speaker& speaker) { known_.erase(speaker); }

  struct Report {
    Speaker speaker;
    std::uint32_t version = 0;
    std::uint64_t others = 0;  ///< that came, too, since the last report
  };
  /// What is to be said now, if anything is. Each participant counts once, and beyond `known_max` of them
  /// none.
  std::optional<Report> take_report(Time now);

 private:
  std::set<Speaker> known_;
  std::optional<Report> next_;
  Time not_before_{};
};

/// In words. `where`: the network interface.
std::string describe(const OtherReleases::Report& report, const std::string& where,
                     std::uint32_t own_version);

}  // namespace sft::core
