// The reports of the demo's processes, which they send on request.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tools/demo/channel.h"

namespace sft::demo {

/// The counts of a subscriber at one moment.
struct Counts {
  std::uint64_t samples = 0;
  std::uint64_t payload_bytes = 0;
  /// Bytes that the interface received, without control traffic; 0: not measured
  std::int64_t wire_bytes = 0;
};

struct SubscriberReport {
  bool matched = false;
  std::string transport;            ///< "shm" or "udp"
  std::string reason;               ///< why this transport is used
  std::vector<std::string> fields;  ///< the fields that the subscriber requests at present
  bool asks_for_all = false;
  Counts counts;
  std::optional<Counts> learnt;  ///< the counts at the time when the recorded mask had narrowed
  std::uint64_t lost = 0;
  std::optional<double> p50_us;
  std::optional<double> p99_us;
};

/// The counts of the publisher for one subscriber.
struct ReaderReport {
  std::string node;
  bool served = false;
  std::string transport;
  std::uint64_t withheld = 0;  ///< samples that were not sent because the reader requests a lower rate
};

struct PublisherReport {
  std::uint64_t published = 0;
  std::uint64_t full_bytes = 0;  ///< the size of the encapsulation and the body of a whole message
  bool finished = false;         ///< true: all samples have been published
  std::vector<ReaderReport> readers;
  std::string udp;  ///< the value of NodeStatus::udp
  std::string shm;  ///< the value of NodeStatus::shm
  bool shm_ready = false;
};

NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(Counts, samples, payload_bytes, wire_bytes)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(SubscriberReport, matched, transport, reason, fields, asks_for_all, counts,
                                   learnt, lost, p50_us, p99_us)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(ReaderReport, node, served, transport, withheld)
NLOHMANN_DEFINE_TYPE_NON_INTRUSIVE(PublisherReport, published, full_bytes, finished, readers, udp, shm,
                                   shm_ready)

}  // namespace sft::demo
