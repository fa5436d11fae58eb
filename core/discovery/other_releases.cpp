#include "core/discovery/other_releases.h"

#include <utility>

namespace sft::core {

void OtherReleases::seen(const Speaker& speaker, std::uint32_t version) {
  if (known_.size() >= known_max || !known_.insert(speaker).second) return;
  if (next_) {
    ++next_->others;
  } else {
    next_ = Report{.speaker = speaker, .version = version};
  }
}

std::optional<OtherReleases::Report> OtherReleases::take_report(Time now) {
  if (!next_ || now < not_before_) return std::nullopt;
  not_before_ = now + pause;
  return std::exchange(next_, std::nullopt);
}

std::string describe(const OtherReleases::Report& report, const std::string& where,
                     std::uint32_t own_version) {
  std::string text = "a participant with control protocol " + std::to_string(report.version) + " is on " +
                     where + "; this node has " + std::to_string(own_version) +
                     "; they do not see each other: use the same release";
  if (report.others > 0)
    text += " (" + std::to_string(report.others) + " more with another protocol have come)";
  return text;
}

}  // namespace sft::core
