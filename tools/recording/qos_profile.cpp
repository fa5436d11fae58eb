#include "tools/recording/qos_profile.h"

#include <algorithm>
#include <charconv>
#include <cstdint>

namespace sft::recording {

namespace {

constexpr std::uint32_t history_most = 128;  // PublisherOptions::history_depth

std::string duration_lines(std::chrono::nanoseconds duration) {
  constexpr std::int64_t second = 1'000'000'000;
  // rosbag2 writes the largest duration for an unlimited duration.
  const std::int64_t ns = duration.count() == 0 ? INT64_MAX : duration.count();
  return "\n    sec: " + std::to_string(ns / second) + "\n    nsec: " + std::to_string(ns % second) + "\n";
}

std::string_view trim(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\"'");
  const std::size_t last = text.find_last_not_of(" \t\r\"'");
  return first == text.npos ? std::string_view() : text.substr(first, last - first + 1);
}

/// The members of a profile that publishers need.
struct Profile {
  bool is_reliable = false;
  bool is_retained = false;
  std::uint32_t depth = 1;
};

void read_line(std::string_view key, std::string_view value, Profile& profile) {
  if (key == "reliability") profile.is_reliable = value == "1" || value == "reliable";
  if (key == "durability") profile.is_retained = value == "1" || value == "transient_local";
  if (key != "depth") return;
  std::uint32_t depth = 0;
  std::from_chars(value.data(), value.data() + value.size(), depth);
  profile.depth = std::clamp(depth, 1U, history_most);
}

}  // namespace

std::string to_profile(const Qos& offered) {
  const bool is_reliable = offered.reliability == reliable;
  const bool is_retained = offered.durability == transient_local;
  return "- history: 1\n  depth: " + std::to_string(offered.history_depth) +
         "\n  reliability: " + (is_reliable ? "1" : "2") + "\n  durability: " + (is_retained ? "1" : "2") +
         "\n  deadline:" + duration_lines(offered.deadline) +
         "  lifespan:" + duration_lines(offered.lifespan) +
         "  liveliness: " + (offered.liveliness == manual_by_topic ? "3" : "1") +
         "\n  liveliness_lease_duration:" + duration_lines(offered.liveliness_lease) +
         "  avoid_ros_namespace_conventions: false";
}

Qos from_profiles(std::string_view text) {
  Qos qos;
  Profile profile;
  std::uint32_t retained = 0;
  const auto end_profile = [&] {
    if (profile.is_reliable) qos.reliability = reliable;
    if (profile.is_retained) qos.durability = transient_local;
    if (profile.is_retained) retained += profile.depth;
    profile = Profile();
  };
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.starts_with('-')) {
      end_profile();
      line.remove_prefix(1);
    }
    const std::size_t colon = line.find(':');
    if (colon != line.npos) read_line(trim(line.substr(0, colon)), trim(line.substr(colon + 1)), profile);
  }
  end_profile();
  qos.history_depth = std::clamp(retained, 1U, history_most);
  return qos;
}

}  // namespace sft::recording
