// One message as Cyclone DDS holds it, with its serializer. What it allocates for sequences is kept from use
// to use.
#pragma once

#include <dds/dds.h>
#include <dds/ddsi/ddsi_cdrstream.h>

#include <cstddef>
#include <span>

namespace sft::bench {

class CycloneMessage {
 public:
  explicit CycloneMessage(const dds_topic_descriptor_t& type);
  CycloneMessage(const CycloneMessage&) = delete;
  CycloneMessage& operator=(const CycloneMessage&) = delete;
  ~CycloneMessage();

  /// As for a sample that arrived: checks it, in place, and fills the C struct. False where it is malformed.
  bool read(std::span<std::byte> body);
  /// From the C struct to a buffer of its own; returns how many bytes it took.
  std::size_t write();

 private:
  const dds_topic_descriptor_t& type_;
  void* sample_;
  dds_ostreamLE_t stream_;
};

}  // namespace sft::bench
