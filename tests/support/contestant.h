// Types as both implementations know them, ours and Cyclone DDS's.
#pragma once

#include <dds/dds.h>

#include <ostream>
#include <string>
#include <vector>

#include "tests/support/message_types.h"

namespace sft::test {

struct Contestant {
  MessageType ours;
  const dds_topic_descriptor_t* theirs;  ///< null: stock idlc makes none, or C that does not compile

  /// "sensor_msgs_msg_Image": letters that a test's name may have.
  std::string name() const {
    std::string result;
    for (const char c : ours.support->name()) {
      if (c != ':') result += c;
      if (c == ':' && result.back() != '_') result += '_';
    }
    return result;
  }
};

inline void PrintTo(const Contestant& type, std::ostream* out) { *out << type.ours.support->name(); }

/// All types of a test program: contestants.py makes the list of what was generated for it.
std::vector<Contestant> contestants();

}  // namespace sft::test
