// The QoS of publishers in the form that rosbag2 writes into recordings ("offered_qos_profiles", a text in
// YAML).
#pragma once

#include <string>
#include <string_view>

#include "sft/qos.h"

namespace sft::recording {

/// Returns the text for one publisher.
std::string to_profile(const Qos& offered);

/// Returns the QoS with which a topic is published again, so that each subscriber that matched one of the
/// publishers matches again: the strongest of all profiles, with a history for the retained samples of all
/// publishers. The text may have any content. Members that it does not have keep their default values. A
/// depth of 0, which means unknown, counts as 1.
Qos from_profiles(std::string_view text);

}  // namespace sft::recording
