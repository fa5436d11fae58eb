// Somebody on the network who speaks for others on the control topics: with Cyclone DDS alone, as any program
// can.
#pragma once

#include <dds/dds.h>

#include <cstdint>
#include <map>

#include "sft_control.h"

namespace sft::test {

class Forger {
 public:
  Forger();
  ~Forger() { dds_delete(participant_); }
  Forger(const Forger&) = delete;
  Forger& operator=(const Forger&) = delete;

  /// Withdraws all endpoints that it knows of.
  void withdraw_all();
  /// Says for all readers that they listen to nobody, in requests that are so far ahead of theirs.
  void mute_all(std::uint64_t ahead);

 private:
  void look();

  dds_entity_t participant_ = 0;
  dds_entity_t endpoints_ = 0, requests_ = 0;  ///< readers
  dds_entity_t endpoint_writer_ = 0, request_writer_ = 0;
  std::map<std::uint64_t, std::uint64_t>
      known_;  ///< the sequence of the newest request by endpoint; 0: a writer
};

}  // namespace sft::test
