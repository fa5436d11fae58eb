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

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <fastdds/dds/publisher/DataWriter.hpp>
#include <fastdds/dds/subscriber/DataReader.hpp>
#include <fastdds/dds/topic/TopicDataType.hpp>
#include <functional>
#include <string>
#include <vector>

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

inline constexpr std::uint32_t encapsulation_bytes = 4;
inline constexpr std::uint8_t little_endian[encapsulation_bytes] = {0, 1, 0, 0};

using Body = std::vector<std::byte>;

/// The type support of a sample that is held as CDR, in place of code from the generator of Fast DDS.
class BodyType : public dds::TopicDataType {
 public:
  /// Each type has a name of its own, since Fast DDS reserves memory for the size of each type.
  BodyType(const std::string& name, std::size_t bytes) {
    const auto bytes_max = static_cast<std::uint32_t>(encapsulation_bytes + bytes);
#if FAST_DDS_3
    set_name(name);
    max_serialized_type_size = bytes_max;
#else
    setName(name.c_str());
    m_typeSize = bytes_max;
    auto_fill_type_object(false);
    auto_fill_type_information(false);
#endif
  }
  BodyType(const BodyType&) = delete;
  BodyType& operator=(const BodyType&) = delete;

#if FAST_DDS_3
  const std::string& name() const { return get_name(); }
#else
  std::string name() { return getName(); }
#endif

 private:
  static Body& body(void* data) { return *static_cast<Body*>(data); }
  static const Body& body(const void* data) { return *static_cast<const Body*>(data); }
  static bool encode(const Body& from, rtps::SerializedPayload_t& payload) {
    payload.encapsulation = CDR_LE;
    std::memcpy(payload.data, little_endian, encapsulation_bytes);
    std::memcpy(payload.data + encapsulation_bytes, from.data(), from.size());
    payload.length = static_cast<std::uint32_t>(encapsulation_bytes + from.size());
    return true;
  }
  static bool decode(const rtps::SerializedPayload_t& payload, Body& to) {
    const auto* bytes = reinterpret_cast<const std::byte*>(payload.data);
    to.assign(bytes + encapsulation_bytes, bytes + payload.length);
    return true;
  }
  static std::uint32_t encoded_bytes(const Body& from) {
    return static_cast<std::uint32_t>(encapsulation_bytes + from.size());
  }

#if FAST_DDS_3
  using Representation = dds::DataRepresentationId_t;
  void* create_data() final { return new Body(); }
  void delete_data(void* data) final { delete static_cast<Body*>(data); }
  bool compute_key(rtps::SerializedPayload_t&, rtps::InstanceHandle_t&, bool) final { return false; }
  bool compute_key(const void*, rtps::InstanceHandle_t&, bool) final { return false; }
  bool serialize(const void* data, rtps::SerializedPayload_t& payload, Representation) final {
    return encode(body(data), payload);
  }
  bool deserialize(rtps::SerializedPayload_t& payload, void* data) final {
    return decode(payload, body(data));
  }
  std::uint32_t calculate_serialized_size(const void* data, Representation) final {
    return encoded_bytes(body(data));
  }
#else
  void* createData() final { return new Body(); }
  void deleteData(void* data) final { delete static_cast<Body*>(data); }
  bool getKey(void*, rtps::InstanceHandle_t*, bool) final { return false; }
  bool serialize(void* data, rtps::SerializedPayload_t* payload) final {
    return encode(body(data), *payload);
  }
  bool deserialize(rtps::SerializedPayload_t* payload, void* data) final {
    return decode(*payload, body(data));
  }
  std::function<std::uint32_t()> getSerializedSizeProvider(void* data) final {
    return [data] { return encoded_bytes(body(data)); };
  }
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
