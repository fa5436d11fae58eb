// The differences between Fast DDS 2 (Debian 12) and Fast DDS 3 (Debian 13): folders, namespaces, and names
// of functions. Contenders use the names of this header. bench/CMakeLists.txt defines FAST_DDS_3.
#pragma once

#if FAST_DDS_3
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.hpp>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.hpp>
#include <fastdds/utils/IPLocator.hpp>
#else
#include <fastdds/rtps/transport/UDPv4TransportDescriptor.h>
#include <fastdds/rtps/transport/shared_mem/SharedMemTransportDescriptor.h>
#include <fastrtps/utils/IPLocator.h>
#endif

#include <cstdint>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <string>

namespace sft::bench::fast {

namespace dds = eprosima::fastdds::dds;
namespace transports = eprosima::fastdds::rtps;

#if FAST_DDS_3
namespace rtps = eprosima::fastdds::rtps;
using Duration = dds::Duration_t;
using ReturnCode = dds::ReturnCode_t;
inline bool is_ok(ReturnCode code) { return code == dds::RETCODE_OK; }
inline bool write(dds::DataWriter& writer, void* data) { return is_ok(writer.write(data)); }
#else
namespace rtps = eprosima::fastrtps::rtps;
using Duration = eprosima::fastrtps::Duration_t;
using ReturnCode = eprosima::fastrtps::types::ReturnCode_t;
inline bool is_ok(const ReturnCode& code) { return code == ReturnCode::RETCODE_OK; }
inline bool write(dds::DataWriter& writer, void* data) { return writer.write(data); }
#endif
using rtps::IPLocator;

/// Fast DDS's interface of a type without keys.
class AnyType : public dds::TopicDataType {
 public:
  AnyType(const AnyType&) = delete;
  AnyType& operator=(const AnyType&) = delete;

 protected:
  AnyType() = default;

  virtual void* make() = 0;
  virtual void unmake(void* data) = 0;
  virtual void encode(const void* data, rtps::SerializedPayload_t& payload) = 0;
  /// Decodes the payload into `data`. Returns false if the payload is malformed.
  virtual bool decode(rtps::SerializedPayload_t& payload, void* data) = 0;
  virtual std::uint32_t encoded_bytes(const void* data) = 0;
  /// Returns true if the bytes of the type in memory are the same as on the wire.
  virtual bool is_same_in_memory() const { return false; }

#if FAST_DDS_3
  void set(const char* name, std::uint32_t bytes) {
    set_name(name);
    max_serialized_type_size = bytes;
  }

 private:
  using Representation = dds::DataRepresentationId_t;
  void* create_data() final { return make(); }
  void delete_data(void* data) final { unmake(data); }
  bool compute_key(rtps::SerializedPayload_t&, rtps::InstanceHandle_t&, bool) final { return false; }
  bool compute_key(const void*, rtps::InstanceHandle_t&, bool) final { return false; }
  bool serialize(const void* data, rtps::SerializedPayload_t& payload, Representation) final {
    encode(data, payload);
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) final { return decode(payload, data); }
  std::uint32_t calculate_serialized_size(const void* data, Representation) final {
    return encoded_bytes(data);
  }
  bool is_plain(Representation) const final { return is_same_in_memory(); }
#else
  void set(const char* name, std::uint32_t bytes) {
    setName(name);
    m_typeSize = bytes;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
  }

 private:
  void* createData() final { return make(); }
  void deleteData(void* data) final { unmake(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) final { return false; }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) final {
    encode(data, *payload);
    return true;
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) final { return decode(*payload, data); }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) final {
    return [this, data] { return encoded_bytes(data); };
  }
  bool is_plain() const final { return is_same_in_memory(); }
#endif

 public:
#if FAST_DDS_3
  const std::string& name() const { return get_name(); }
#else
  std::string name() { return getName(); }
#endif
};

/// Makes a writer announce its samples, and a reader request missing samples, without much delay. By
/// default, Fast DDS requests missing fragments only every 3 s.
inline void answer_soon(dds::DataWriterQos& qos) {
  auto& times = qos.reliable_writer_qos().times;
#if FAST_DDS_3
  times.heartbeat_period = Duration(0.01);
  times.nack_response_delay = {0, 0};
#else
  times.heartbeatPeriod = Duration(0.01);
  times.nackResponseDelay = {0, 0};
#endif
}
inline void ask_at_once(dds::DataReaderQos& qos) {
  auto& times = qos.reliable_reader_qos().times;
#if FAST_DDS_3
  times.heartbeat_response_delay = {0, 0};
#else
  times.heartbeatResponseDelay = {0, 0};
#endif
}

}  // namespace sft::bench::fast
