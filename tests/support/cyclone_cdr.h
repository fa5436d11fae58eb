// Cyclone DDS's own serializer, used without a domain or a network. It converts C structs of stock idlc to
// CDR and back.
#pragma once

#include <dds/dds.h>

#include <bit>
#include <cstddef>
#include <span>
#include <vector>

namespace sft::test {

/// Returns the sample as XCDR1, little-endian, without encapsulation.
std::vector<std::byte> cyclone_serialize(const dds_topic_descriptor_t& type, const void* c_struct);
/// Returns the sample in the given version of XCDR and byte order, without encapsulation.
std::vector<std::byte> cyclone_serialize(const dds_topic_descriptor_t& type, const void* c_struct,
                                         bool is_xcdr2, std::endian byte_order);

class CycloneReader {
 public:
  explicit CycloneReader(const dds_topic_descriptor_t& type) : type_(&type) {}
  CycloneReader(const CycloneReader&) = delete;
  CycloneReader& operator=(const CycloneReader&) = delete;
  ~CycloneReader() { free_sample(); }

  /// Returns the C struct, which is valid until the next call. Returns null if Cyclone finds the bytes
  /// malformed, or if bytes follow the message.
  const void* deserialize(std::span<const std::byte> body);

 private:
  void free_sample();

  const dds_topic_descriptor_t* type_;
  void* sample_ = nullptr;
};

/// Returns true if Cyclone writes the type in the plain encoding of XCDR1, because the type is final and
/// needs no feature of XCDR2.
bool cyclone_writes_plain_cdr(const dds_topic_descriptor_t& type);

}  // namespace sft::test
