// The messages that are encoded and decoded, for all contenders.
#pragma once

#include <cstddef>
#include <nav_msgs/msg/Odometry.hpp>
#include <string>
#include <vector>

#include "bench/common/cloud.h"
#include "sft/detail/encode.h"
#include "sft/detail/walk.h"

namespace sft::bench {

inline constexpr std::size_t large_bytes = 1'660'000;  ///< bytes of 103,750 points of 16 bytes
inline constexpr std::size_t small_bytes = 16;

nav_msgs::msg::Odometry odometry();

/// The memory of a sample: its body, index and mask.
class Sample {
 public:
  /// Allocates memory for `value` under `mask`, which must be closed, and encodes `value`.
  template <class T>
  explicit Sample(const T& value, const FieldMask& mask = FieldMask(all<T>))
      : Sample(detail::TypeTable<T>::type, &value, mask) {}
  Sample(const StructType& type, const void* value, const FieldMask& mask);
  Sample(const Sample&) = delete;
  Sample& operator=(const Sample&) = delete;

  /// Encodes a value once more, like a publisher for each sample.
  void encode_again(const void* value);

  std::span<std::byte> body() { return {reinterpret_cast<std::byte*>(memory_.data()), bytes_}; }
  std::span<std::uint32_t> index() { return index_; }
  const detail::SampleState& state() const { return state_; }

 private:
  const StructType& type_;
  FieldMask mask_;
  std::uint32_t bytes_;
  std::vector<std::uint64_t> memory_;
  std::vector<std::uint32_t> index_;
  detail::SampleState state_;
};

}  // namespace sft::bench
