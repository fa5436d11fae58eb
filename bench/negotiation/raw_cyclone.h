// The references: Cyclone DDS alone, in a domain with our configuration, with messages of the size of a
// request.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "bench/common/cyclone.h"

namespace sft::bench {

/// One participant, and the domain with it.
class RawCyclone {
 public:
  enum class Delivery {
    best_effort,  ///< volatile
    last_value,   ///< reliable, transient-local, keep-last 1: as control topics
  };
  /// Told the number of each message, on a thread of Cyclone's.
  using Arrived = std::function<void(std::uint64_t)>;

  /// Ends the program with a message where Cyclone refuses.
  RawCyclone();

  dds_entity_t writer(const std::string& topic, Delivery delivery);
  /// `arrived` outlives the reader.
  dds_entity_t reader(const std::string& topic, Delivery delivery, const Arrived& arrived);

  static void write(dds_entity_t writer, std::uint64_t number);
  /// How many read what the writer writes.
  static std::size_t readers(dds_entity_t writer) { return CycloneParticipant::readers(writer); }

 private:
  const CycloneParticipant participant_;
};

}  // namespace sft::bench
