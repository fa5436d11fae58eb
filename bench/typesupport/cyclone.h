// One message of Cyclone DDS, with its serializer. Memory for sequences is allocated once and reused.
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

  /// Checks a body in place and fills the C struct, as for an arriving sample. Returns false if the body is
  /// malformed.
  bool read(std::span<std::byte> body);
  /// Encodes the C struct into a buffer of this object, and returns the number of bytes.
  std::size_t write();

 private:
  const dds_topic_descriptor_t& type_;
  void* sample_;
  dds_ostreamLE_t stream_;
};

}  // namespace sft::bench
