// Types as both implementations know them, ours and Cyclone DDS's.
#pragma once

#include <dds/dds.h>

#include <ostream>
#include <vector>

#include "tests/support/message_types.h"

namespace sft::test {

struct Contestant {
  MessageType ours;
  const dds_topic_descriptor_t* theirs;  ///< null: stock idlc makes none, or C that does not compile
};

inline void PrintTo(const Contestant& type, std::ostream* out) { *out << type.ours.support->name(); }

/// All types of a test program: contestants.py makes the list of what was generated for it.
std::vector<Contestant> contestants();

}  // namespace sft::test
