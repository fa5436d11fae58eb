// The DDS policies of the control topics and of our participants.
#pragma once

#include <dds/dds.h>

#include <chrono>
#include <memory>
#include <string>

#include "core/discovery/participant_mark.h"

namespace sft::core {

struct QosDeleter {
  void operator()(dds_qos_t* qos) const { dds_delete_qos(qos); }
};
using DdsQos = std::unique_ptr<dds_qos_t, QosDeleter>;

/// For endpoints and requests: reliable, and kept for participants that come later.
DdsQos control_qos();
/// For signs of life, which are repeated. Their lease is Cyclone's to watch, and covers all that is written.
DdsQos assertion_qos(std::chrono::milliseconds lease);
DdsQos copy_of(const dds_qos_t* qos);
/// The policies of readers of a topic that is written with `written`. Readers do not hear their own
/// participant. They request no lease, or they would not hear others whose own lease is longer: Cyclone
/// watches each writer's own lease.
DdsQos hearing_qos(const dds_qos_t* written);
/// For a participant. Others tell our participants from other programs' by their user data, and Cyclone tells
/// everybody when these change.
DdsQos participant_qos(const ParticipantMark& mark);

std::string user_data_of(const dds_qos_t* qos);
/// The lease of a writer's signs of life; longest_lease if it has none.
std::chrono::milliseconds liveliness_lease(const dds_qos_t* qos);
inline constexpr std::chrono::hours longest_lease{24};

}  // namespace sft::core
