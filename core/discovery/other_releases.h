// Reports nodes that this node sees and cannot speak with, because their control topics are of another
// version. However many such nodes somebody makes up, people are told one line in a while. Pure.
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

  /// A participant tells another version, each time that it does.
  void seen(const Speaker& speaker, std::uint32_t version);
  void departed(const Speaker& speaker) { known_.erase(speaker); }

  struct Report {
    Speaker speaker;
    std::uint32_t version = 0;
    std::uint64_t others = 0;  ///< further participants since the last report
  };
  /// The report that is due now, if any. Each participant counts once, and no more than `known_max` count.
  std::optional<Report> take_report(Time now);

 private:
  std::set<Speaker> known_;
  std::optional<Report> next_;
  Time not_before_{};
};

/// The report in words. `where`: the network interface.
std::string describe(const OtherReleases::Report& report, const std::string& where,
                     std::uint32_t own_version);

}  // namespace sft::core
