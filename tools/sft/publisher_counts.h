// Measures a topic by the counts of its publishers, without a subscriber. Used for types whose fields are
// not known.
#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "tools/sft/session.h"
#include "tools/sft/traffic.h"

namespace sft::tool {

/// The counts of a topic's publishers. Publishers count only samples that they send to subscribers. So the
/// counts do not grow while there are no subscribers.
class PublisherCounts {
 public:
  /// Begins to count. The session must outlive this object.
  PublisherCounts(std::string topic, const Session& session);

  struct Report {
    double rate_hz = 0;         ///< the sum over all publishers
    double bytes_per_s = 0;     ///< bytes over the network, summed over the subscribers
    std::uint64_t samples = 0;  ///< the number of samples since the beginning
    std::uint64_t fresh = 0;    ///< the number of samples since the last report
  };
  Report report();

  const std::string& topic() const { return topic_; }

 private:
  const std::string topic_;
  const Session& session_;
  Traffic traffic_;
  std::map<std::uint64_t, std::uint64_t> counted_;  ///< the count of each publisher at the last report
  std::uint64_t samples_ = 0;
};

/// Returns counts for a topic for which find() has failed because its nodes announce no fields, and prints a
/// line about this for the user. Returns null if find() has failed for another reason.
std::unique_ptr<PublisherCounts> counts_instead(const std::string& topic, const Error& error,
                                                const Session& session);

}  // namespace sft::tool
