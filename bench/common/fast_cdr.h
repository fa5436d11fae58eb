// Reads and writes the benchmark's messages with Fast CDR, member by member, like code that Fast DDS
// generates.
#pragma once

#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>

#include <cstddef>
#include <nav_msgs/msg/Odometry.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>
#include <vector>

namespace sft::bench {

// The list of members, used for both directions. Io is FastCdrReader or FastCdrWriter.
template <class Io>
void members(Io& io, builtin_interfaces::msg::Time& m) {
  io.all(m.sec, m.nanosec);
}
template <class Io>
void members(Io& io, std_msgs::msg::Header& m) {
  io.all(m.stamp, m.frame_id);
}
template <class Io>
void members(Io& io, sensor_msgs::msg::PointField& m) {
  io.all(m.name, m.offset, m.datatype, m.count);
}
template <class Io>
void members(Io& io, sensor_msgs::msg::PointCloud2& m) {
  io.all(m.header, m.height, m.width, m.fields, m.is_bigendian, m.point_step, m.row_step, m.data, m.is_dense);
}
template <class Io>
void members(Io& io, geometry_msgs::msg::Point& m) {
  io.all(m.x, m.y, m.z);
}
template <class Io>
void members(Io& io, geometry_msgs::msg::Vector3& m) {
  io.all(m.x, m.y, m.z);
}
template <class Io>
void members(Io& io, geometry_msgs::msg::Quaternion& m) {
  io.all(m.x, m.y, m.z, m.w);
}
template <class Io>
void members(Io& io, geometry_msgs::msg::Pose& m) {
  io.all(m.position, m.orientation);
}
template <class Io>
void members(Io& io, geometry_msgs::msg::Twist& m) {
  io.all(m.linear, m.angular);
}
template <class Io>
void members(Io& io, geometry_msgs::msg::PoseWithCovariance& m) {
  io.all(m.pose, m.covariance);
}
template <class Io>
void members(Io& io, geometry_msgs::msg::TwistWithCovariance& m) {
  io.all(m.twist, m.covariance);
}
template <class Io>
void members(Io& io, nav_msgs::msg::Odometry& m) {
  io.all(m.header, m.child_frame_id, m.pose, m.twist);
}

class FastCdrStream {
 public:
  /// `memory` begins with the body, and must have at least the alignment of the body.
  explicit FastCdrStream(std::span<std::byte> memory)
      : buffer_(reinterpret_cast<char*>(memory.data()), memory.size()), cdr_(make(buffer_)) {}

  /// Returns the number of bytes of the body that were read or written so far.
  std::size_t bytes() const { return bytes_of(cdr_); }

 protected:
  eprosima::fastcdr::FastBuffer buffer_;
  eprosima::fastcdr::Cdr cdr_;

 private:
  // Fast CDR 2 (Debian 13) has other names than Fast CDR 1 (Debian 12). By default, Fast CDR 2 aligns
  // numbers of 8 bytes to 4 bytes.
  static eprosima::fastcdr::Cdr make(eprosima::fastcdr::FastBuffer& buffer) {
    using eprosima::fastcdr::Cdr;
#if __has_include(<fastcdr/CdrSizeCalculator.hpp>)
    return Cdr(buffer, Cdr::DEFAULT_ENDIAN, eprosima::fastcdr::CdrVersion::XCDRv1);
#else
    return Cdr(buffer);
#endif
  }
  static std::size_t bytes_of(const eprosima::fastcdr::Cdr& cdr) {
#if __has_include(<fastcdr/CdrSizeCalculator.hpp>)
    return cdr.get_serialized_data_length();
#else
    return cdr.getSerializedDataLength();
#endif
  }
};

class FastCdrReader : public FastCdrStream {
 public:
  using FastCdrStream::FastCdrStream;

  template <class... Members>
  void all(Members&... values) {
    (one(values), ...);
  }

 private:
  template <class V>
  void one(V& value) {
    if constexpr (requires { members(*this, value); }) {
      members(*this, value);
    } else {
      cdr_ >> value;
    }
  }
  void one(std::vector<sensor_msgs::msg::PointField>& values) {
    std::uint32_t length = 0;
    cdr_ >> length;
    values.resize(length);
    for (auto& value : values) members(*this, value);
  }
};

class FastCdrWriter : public FastCdrStream {
 public:
  using FastCdrStream::FastCdrStream;

  template <class... Members>
  void all(Members&... values) {
    (one(values), ...);
  }

 private:
  template <class V>
  void one(V& value) {
    if constexpr (requires { members(*this, value); }) {
      members(*this, value);
    } else {
      cdr_ << value;
    }
  }
  void one(std::vector<sensor_msgs::msg::PointField>& values) {
    cdr_ << static_cast<std::uint32_t>(values.size());
    for (auto& value : values) members(*this, value);
  }
};

}  // namespace sft::bench
