// The QoS of publishers as rosbag2 writes it into recordings ("offered_qos_profiles", a text in YAML).
#pragma once

#include <string>
#include <string_view>

#include "sft/qos.h"

namespace sft::recording {

/// The text for one publisher.
std::string to_profile(const Qos& offered);

/// The QoS with which a topic is offered again, so that whoever heard one of the publishers hears it: the
/// strongest of all profiles, and history for the retained samples of all. The text may be anything: what it
/// does not say stays as it is by default. A depth of 0, which means unknown, counts as 1.
Qos from_profiles(std::string_view text);

}  // namespace sft::recording
