// Takes what others say on the control topics out of Cyclone's readers. The samples are checked
// (control_codec.h).
#pragma once

#include <dds/dds.h>

#include <optional>

#include "core/discovery/control_word.h"
#include "core/discovery/heard_keys.h"
#include "core/discovery/participants.h"
#include "core/discovery/remote_writers.h"

namespace sft::core {

/// A reader keeps this of the samples that it has taken, since later samples refer to it.
struct Heard {
  RemoteWriters writers;
  HeardKeys keys;
};

// Each function takes all samples that its reader has.

ControlWords take_writers(dds_entity_t reader, Heard& heard);
ControlWords take_readers(dds_entity_t reader, Heard& heard);
ControlWords take_assertions(dds_entity_t reader, Heard& heard);

/// Empty if the writer, or reader, is not matched any more.
std::optional<Participants::Guid> publishing_participant(dds_entity_t reader, dds_instance_handle_t writer);
std::optional<Participants::Guid> subscribing_participant(dds_entity_t writer, dds_instance_handle_t reader);

Participants::Guid to_guid(const dds_guid_t& guid);

}  // namespace sft::core
