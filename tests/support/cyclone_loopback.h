// A Cyclone DDS writer and reader of a type, in a domain of their own on the loopback interface only. The
// writer and the reader exchange the same payloads as over a network, including the encapsulation.
#pragma once

#include <dds/dds.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace sft::test {

struct CyclonePayload {
  /// The last two bits, which give the number of padding bytes, are set to 0.
  std::array<std::uint8_t, 4> encapsulation{};
  std::vector<std::byte> body;  ///< the body without padding
};

class CycloneLoopback {
 public:
  explicit CycloneLoopback(const dds_topic_descriptor_t& type);
  CycloneLoopback(const CycloneLoopback&) = delete;
  CycloneLoopback& operator=(const CycloneLoopback&) = delete;
  ~CycloneLoopback();

  bool ok() const { return error_.empty(); }
  const std::string& error() const { return error_; }

  /// Returns the payload that the writer sends for this sample.
  CyclonePayload sent(const void* c_struct);

  /// Lets the reader take a sample with this body, and calls `visit` with its C struct. Returns false if no
  /// sample arrives.
  bool receive(std::span<const std::byte> body, const std::function<void(const void*)>& visit);

 private:
  dds_entity_t checked(dds_entity_t entity, const char* what);
  ddsi_serdata* written(const void* c_struct);

  std::string error_;
  dds_entity_t domain_ = 0;
  dds_entity_t reader_ = 0;
  dds_entity_t writer_ = 0;
  ddsi_serdata* prototype_ = nullptr;  ///< a sample that gives access to Cyclone's internal type
};

}  // namespace sft::test
