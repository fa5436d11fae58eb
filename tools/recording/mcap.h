// The parts of a recording, in the words of MCAP (https://mcap.dev/spec). All structs are values, except
// that the data of a message belong to the object that made it.
#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "tools/recording/bytes.h"

namespace sft::recording {

/// The eight bytes at both ends of a file.
inline constexpr std::string_view magic = "\x89MCAP0\r\n";

/// The kinds of records.
enum class Opcode : std::uint8_t {
  header = 1,
  footer,
  schema,
  channel,
  message,
  chunk,
  message_index,
  chunk_index,
  attachment,
  attachment_index,
  statistics,
  metadata,
  metadata_index,
  summary_offset,
  data_end
};

inline constexpr std::size_t record_head_bytes = 9;    ///< the opcode, and the length of what follows
inline constexpr std::size_t message_head_bytes = 22;  ///< what a message record has before its data

/// The definition of a message type.
struct Schema {
  std::uint16_t id = 0;
  std::string name{};      ///< "sensor_msgs/msg/Imu"
  std::string encoding{};  ///< "ros2msg" or "ros2idl"; empty: the file has no definition
  std::string data{};
  friend bool operator==(const Schema&, const Schema&) = default;
};

/// The messages of a topic that have one schema, and here also one publisher's QoS.
struct Channel {
  std::uint16_t id = 0;
  std::uint16_t schema = 0;  ///< 0: none
  std::string topic{};
  std::string encoding = "cdr";
  Texts metadata{};
  friend bool operator==(const Channel&, const Channel&) = default;
};

struct Message {
  std::uint16_t channel = 0;
  std::uint32_t sequence = 0;
  std::uint64_t log_ns = 0;      ///< when it was recorded, by the clock of the recording
  std::uint64_t publish_ns = 0;  ///< when it was published, by the clock of the publisher
  std::span<const std::byte> data{};
};

}  // namespace sft::recording
