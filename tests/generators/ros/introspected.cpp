#include "tests/generators/ros/introspected.h"

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <cstdint>
#include <rosidl_typesupport_introspection_cpp/field_types.hpp>
#include <string>

namespace sft::test {
namespace {

using eprosima::fastcdr::Cdr;
using eprosima::fastcdr::FastBuffer;
using rosidl_typesupport_introspection_cpp::MessageMember;

// Fast CDR 2 (Debian 13) has other names than Fast CDR 1 (Debian 12). By default, Fast CDR 2 aligns numbers
// of 8 bytes to 4 bytes.
Cdr cdr_in(FastBuffer& buffer) {
#if __has_include(<fastcdr/CdrSizeCalculator.hpp>)
  return Cdr(buffer, Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::CdrVersion::XCDRv1);
#else
  return Cdr(buffer);
#endif
}
std::size_t bytes_in(const Cdr& cdr) {
#if __has_include(<fastcdr/CdrSizeCalculator.hpp>)
  return cdr.get_serialized_data_length();
#else
  return cdr.getSerializedDataLength();
#endif
}

/// Calls `use` with a value of the type of one element.
template <class Use>
void with_value(const MessageMember& member, Use use) {
  namespace ros = rosidl_typesupport_introspection_cpp;
  switch (member.type_id_) {
    case ros::ROS_TYPE_FLOAT:
      return use(float{});
    case ros::ROS_TYPE_DOUBLE:
      return use(double{});
    case ros::ROS_TYPE_BOOLEAN:
      return use(bool{});
    case ros::ROS_TYPE_INT8:
      return use(std::int8_t{});
    case ros::ROS_TYPE_INT16:
      return use(std::int16_t{});
    case ros::ROS_TYPE_UINT16:
      return use(std::uint16_t{});
    case ros::ROS_TYPE_INT32:
      return use(std::int32_t{});
    case ros::ROS_TYPE_UINT32:
      return use(std::uint32_t{});
    case ros::ROS_TYPE_INT64:
      return use(std::int64_t{});
    case ros::ROS_TYPE_UINT64:
      return use(std::uint64_t{});
    case ros::ROS_TYPE_STRING:
      return use(std::string{});
    default:
      return use(std::uint8_t{});  // char, octet and uint8
  }
}

bool is_struct(const MessageMember& member) {
  return member.type_id_ == rosidl_typesupport_introspection_cpp::ROS_TYPE_MESSAGE;
}
bool is_sequence(const MessageMember& member) {
  return member.is_array_ && (member.array_size_ == 0 || member.is_upper_bound_);
}
const RosMembers& members_of(const MessageMember& member) {
  return *static_cast<const RosMembers*>(member.members_->data);
}

void write(Cdr& cdr, const RosMembers& type, const void* message) {
  for (const MessageMember& member : std::span(type.members_, type.member_count_)) {
    const void* const at = static_cast<const std::byte*>(message) + member.offset_;
    const std::size_t elements = !member.is_array_     ? 1
                                 : is_sequence(member) ? member.size_function(at)
                                                       : member.array_size_;
    if (is_sequence(member)) cdr << static_cast<std::uint32_t>(elements);
    for (std::size_t i = 0; i < elements; ++i) {
      if (is_struct(member)) {
        write(cdr, members_of(member), member.is_array_ ? member.get_const_function(at, i) : at);
        continue;
      }
      with_value(member, [&]<class V>(V value) {
        if (member.is_array_) member.fetch_function(at, i, &value);
        cdr << (member.is_array_ ? value : *static_cast<const V*>(at));
      });
    }
  }
}

void read(Cdr& cdr, const RosMembers& type, void* message) {
  for (const MessageMember& member : std::span(type.members_, type.member_count_)) {
    void* const at = static_cast<std::byte*>(message) + member.offset_;
    auto elements = static_cast<std::uint32_t>(member.is_array_ ? member.array_size_ : 1);
    if (is_sequence(member)) {
      cdr >> elements;
      member.resize_function(at, elements);
    }
    for (std::size_t i = 0; i < elements; ++i) {
      if (is_struct(member)) {
        read(cdr, members_of(member), member.is_array_ ? member.get_function(at, i) : at);
        continue;
      }
      with_value(member, [&]<class V>(V value) {
        cdr >> value;
        if (member.is_array_) {
          member.assign_function(at, i, &value);
        } else {
          *static_cast<V*>(at) = value;
        }
      });
    }
  }
}

}  // namespace

std::vector<std::byte> serialized_by_ros(const RosMembers& type, const void* message, std::size_t bytes_max) {
  std::vector<std::byte> body(bytes_max);  // Fast CDR leaves padding as it is
  FastBuffer buffer(reinterpret_cast<char*>(body.data()), body.size());
  Cdr cdr = cdr_in(buffer);
  write(cdr, type, message);
  body.resize(bytes_in(cdr));
  return body;
}

void deserialize_by_ros(const RosMembers& type, std::span<const std::byte> body, void* message) {
  std::vector<char> copy(reinterpret_cast<const char*>(body.data()),
                         reinterpret_cast<const char*>(body.data()) + body.size());
  FastBuffer buffer(copy.data(), copy.size());
  Cdr cdr = cdr_in(buffer);
  read(cdr, type, message);
}

}  // namespace sft::test
