// Another process, as an ear hears it.
#pragma once

#include <cstdint>

#include "core/control/control.h"
#include "core/control/control_digest.h"
#include "core/discovery/participants.h"
#include "core/discovery/pulse.h"
#include "core/discovery/speakers.h"

namespace sft::core::test {

using namespace std::chrono_literals;

inline constexpr LinkId lan_of_others = 1;

/// The number of a node and that of its writer tell each other.
constexpr NodeId node_of_writer(EndpointId writer) { return writer - 1000; }

/// A process with one node, which has a writer.
struct OtherProcess {
  OtherProcess(Participants& participants, std::uint8_t number) : guid{number}, node(1000u + number) {
    speaker = {lan_of_others, participants.number_of(guid)};
    writer.id = 2000u + number;
    writer.node_id = node;
    writer.role = Role::writer;
    writer.topic = number % 4 == 0 ? "wanted" : "unwanted";
  }
  Pulse pulse() const {
    return {.node = node,
            .participant = Participants::tag_of(guid),
            .digest_of_writers = digest(),
            .full_signs = full_signs};
  }
  Assertion full_sign() {
    ++full_signs;
    Assertion sign{.node = node, .writers = {}};
    sign.digest_of_writers = digest();
    sign.progress = {{writer.id, ++samples, 0}};
    return sign;
  }
  std::uint32_t digest() const { return add_to_digest(0, digest_part(writer.id, writer.revision, 0)); }

  Participants::Guid guid;
  Speaker speaker;
  NodeId node;
  Endpoint writer;
  Pulse sent{};  ///< the last one
  std::uint8_t full_signs = 0;
  std::uint64_t samples = 0;  ///< that it says to have published
  unsigned signs = 0;
  bool is_dead = false;
};

}  // namespace sft::core::test
