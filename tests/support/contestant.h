// Message types of both implementations: SFT's and Cyclone DDS's.
#pragma once

#include <dds/dds.h>

#include <ostream>
#include <vector>

#include "tests/support/message_types.h"

namespace sft::test {

struct Contestant {
  MessageType ours;
  const dds_topic_descriptor_t* theirs;  ///< null if stock idlc generates nothing, or C that does not compile
};

inline void PrintTo(const Contestant& type, std::ostream* out) { *out << type.ours.support->name(); }

/// Returns all types that were generated for a test program. contestants.py makes the list.
std::vector<Contestant> contestants();

}  // namespace sft::test
