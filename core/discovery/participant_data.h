// The user data of our DDS participants: which process the participant belongs to, and how it wants to be
// heard. Cyclone tells everybody at once when they change. Also the participants of other releases that a
// node sees and cannot understand. Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <string_view>

#include "core/discovery/records.h"
#include "core/discovery/timing.h"
#include "core/platform/clock.h"

namespace sft::core {

struct ParticipantData {
  ProcessId process = 0;
  bool is_secured = false;  ///< by DDS Security: it does not understand those that are not
  bool uses_topic = false;  ///< its heartbeats go and come by the topic sft_heartbeat, too
  bool asks = false;        ///< whoever hears that announces itself once more
  unsigned count = 0;       ///< from 0 to 9: makes a change, so that Cyclone says it again
  friend bool operator==(const ParticipantData&, const ParticipantData&) = default;
};

/// "sft/15/3sta/0123456789abcdef": the version, the count, the letters of what is true, the process.
std::string to_text(const ParticipantData& data);
/// In the user data of the endpoints, and of their participant, that SFT makes for DDS nodes which know
/// nothing of SFT. Such user data are pairs, as in "key=value;".
inline constexpr std::string_view vanilla_mark = "sft=1;";
/// True if these user data are those of a participant or an endpoint of SFT, of whatever release.
bool is_of_sft(std::string_view user_data);
/// Nothing if the user data are not those of a participant of this version.
std::optional<ParticipantData> parse_participant_data(std::string_view user_data);
/// The version of the control protocol if it is another one than ours. The user data of all versions begin
/// with "sft/", the version and "/".
std::optional<std::uint32_t> other_release(std::string_view user_data);

/// Decides when the log names participants of other releases. However many of them somebody makes up, people
/// read one line in a while.
class ReleaseMonitor {
 public:
  explicit ReleaseMonitor(const Timing& timing) : timing_(timing) {}

  /// A participant has another version, each time that this is heard.
  void seen(const RemoteParticipant& participant, std::uint32_t version);
  void gone(const RemoteParticipant& participant) { known_.erase(participant); }
  void link_gone(LinkId link) {
    std::erase_if(known_, [link](const RemoteParticipant& one) { return one.link == link; });
  }

  struct Report {
    RemoteParticipant participant{};
    std::uint32_t version = 0;
    std::uint64_t others = 0;  ///< further participants since the last report
  };
  /// The report that is due now, if any. Each participant counts once, and no more than `known_max` count.
  std::optional<Report> take_report(Time now);

 private:
  static constexpr std::size_t known_max = 256;

  const Timing timing_;
  std::set<RemoteParticipant> known_;
  std::optional<Report> next_;
  Time not_before_{};
};

}  // namespace sft::core
