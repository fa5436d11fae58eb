// The reference: Cyclone DDS alone, in a domain with SFT's configuration, and with messages of the size of a
// request.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "bench/common/cyclone.h"

namespace sft::bench {

/// One participant, and its domain.
class RawCyclone {
 public:
  enum class Delivery {
    best_effort,  ///< volatile
    last_value,   ///< reliable, transient-local, keep-last 1, as control topics are
  };
  /// Called with the number of each message, on a thread of Cyclone DDS.
  using Arrived = std::function<void(std::uint64_t)>;

  /// Ends the program with a message if Cyclone DDS returns an error.
  RawCyclone();

  dds_entity_t writer(const std::string& topic, Delivery delivery);
  /// `arrived` outlives the reader.
  dds_entity_t reader(const std::string& topic, Delivery delivery, const Arrived& arrived);

  static void write(dds_entity_t writer, std::uint64_t number);
  /// The number of readers that are matched with the writer.
  static std::size_t readers(dds_entity_t writer) { return CycloneParticipant::readers(writer); }

 private:
  const CycloneParticipant participant_;
};

}  // namespace sft::bench
