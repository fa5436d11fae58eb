// The user data of our DDS participants: the process that the participant belongs to, and how its
// heartbeats are sent. Cyclone announces a change of user data at once. Pure functions.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/discovery/records.h"

namespace sft::core {

struct ParticipantData {
  ProcessId process = 0;
  bool is_secured = false;  ///< the participant uses DDS Security, and cannot communicate with participants
                            ///< that do not
  bool uses_topic = false;  ///< sends and receives heartbeats by the topic sft_heartbeat, too
  bool asks = false;        ///< asks other participants to announce themselves once more
  unsigned count = 0;       ///< a counter from 0 to 9; changing it makes Cyclone send the user data again
  friend bool operator==(const ParticipantData&, const ParticipantData&) = default;
};

/// Returns "sft/16/3sta/0123456789abcdef": the version, the count, a letter for each flag that is true, the
/// process.
std::string to_text(const ParticipantData& data);
/// A part of the user data of the participant that SFT makes for DDS nodes which know nothing of SFT, and
/// of the endpoints of this participant. Such user data are pairs of the form "key=value;".
inline constexpr std::string_view vanilla_mark = "sft=1;";
/// Returns the user data of a participant or an endpoint; empty if it has none.
std::string user_data_in(const dds_qos_t* qos);
/// Returns true if these user data are those of a participant or an endpoint of SFT, of any release.
bool is_of_sft(std::string_view user_data);
/// Returns nothing if the user data are not those of a participant of this version.
std::optional<ParticipantData> parse_participant_data(std::string_view user_data);
/// Returns the version of the control protocol if it differs from ours. Otherwise returns nothing. In all
/// versions the user data begin with "sft/", the version and "/".
std::optional<std::uint32_t> other_release(std::string_view user_data);

}  // namespace sft::core
