// A writer and a reader of point clouds on the topic "points", as nodes of ROS 2 would open them. They use
// the struct that Cyclone DDS generates, and know nothing of SFT.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "bench/common/cyclone.h"
#include "vanilla_messages.h"

namespace sft::bench {

inline constexpr std::uint32_t vanilla_cloud_bytes = 6'291'456;  ///< the data of 393,216 points of 16 bytes
/// The time between two samples.
inline constexpr std::int64_t vanilla_period_ns = 100'000'000;

class PlainWriter {
 public:
  explicit PlainWriter(std::uint32_t data_bytes);

  std::size_t readers() const { return CycloneParticipant::readers(writer_); }
  void write(std::uint32_t number);

 private:
  const CycloneParticipant participant_;
  std::vector<std::uint8_t> data_;
  const dds_entity_t writer_;
};

class PlainReader {
 public:
  /// Opens a reader. A thread of Cyclone takes each sample as a struct, and then calls `arrived` with its
  /// number.
  explicit PlainReader(std::function<void(std::uint32_t)> arrived);
  ~PlainReader();
  PlainReader(const PlainReader&) = delete;
  PlainReader& operator=(const PlainReader&) = delete;

  std::size_t writers() const { return CycloneParticipant::writers(reader_); }

 private:
  void take(dds_entity_t reader);

  const CycloneParticipant participant_;
  const std::function<void(std::uint32_t)> arrived_;
  sensor_msgs_msg_dds__PointCloud2_ cloud_{};
  const dds_entity_t reader_;
};

/// Returns the processor time of all threads of this process.
std::int64_t process_cpu_ns();

}  // namespace sft::bench
