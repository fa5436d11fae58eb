// The figures of a run. The demo measures them; the table, the summary and a JSON file show them.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "tools/demo/roles/protocol.h"

namespace sft::demo {

struct SubscriberFigures {
  std::string name;
  Route route{};
  SubscriberReport counts{};

  bool in_shared_memory() const { return route.in_shared_memory; }
  /// Bytes of a cloud, once the fields are known.
  double sent_bytes() const;
  /// The share of all whole clouds that was not sent to it.
  double saved(double whole_bytes) const;
};

/// Sums over all subscribers that are not served in shared memory.
struct Carried {
  double bytes = 0;        ///< bytes that were sent
  double whole_bytes = 0;  ///< bytes of all whole clouds to all of them
  double saved() const { return whole_bytes > 0 ? 1 - bytes / whole_bytes : 0; }
};

struct RunFigures {
  std::string input{};
  std::string message_shape{};  ///< for people: "128 x 1024 points"
  double hz = 0;
  bool recorded = false;  ///< the fields of all subscribers are recorded, not declared
  std::uint64_t samples = 0;
  double whole_bytes = 0;  ///< of a cloud with all fields, on average
  unsigned hosts = 0;      ///< 1: there are no real ones, and bytes are payload, not what was on the wire
  std::vector<SubscriberFigures> subscribers{};

  bool real_hosts() const { return hosts > 1; }
  std::uint64_t lost() const;
  Carried carried() const;
};

/// A text that ends with a line break.
std::string to_json(const RunFigures& run);

}  // namespace sft::demo
